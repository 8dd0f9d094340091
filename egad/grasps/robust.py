"""Grasp quality under uncertainty: the mean over perturbed copies of a grasp.

The random variables are those that Dex-Net documents (Mahler et al., RSS 2017). Our changes: every
copy has its own object pose, the center of mass is perturbed around its true position, and a finger
that meets the object beyond the middle pushes it along instead of missing it.
"""

from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from egad._util.arrays import Floats
from egad.geometry import RayCaster
from egad.grasps.antipodal import ContactPairs
from egad.grasps.parameters import ROBUST_TORQUE_SCALING, SPREAD, Quality, Robust, Spread
from egad.grasps.quality import ferrari_canny
from egad.grippers import HandBody, JawBody


class JawFaces(NamedTuple):
    """The inner faces of a hand with one moving jaw, at n grasps (ours).

    Jaws that turn are parallel at one opening only: the closing force leans by half the angle to
    either face, and friction must carry that at each contact, or the object is squeezed out.
    """

    body: JawBody
    approaches: Floats  # (n, 3) unit vectors along which it points
    excess: Floats  # (n,) how much wider than the contacts it stays open, stopped before, metres

    @classmethod
    def of(
        cls, body: HandBody, grasps: ContactPairs, approaches: Floats, needed: Floats
    ) -> Self | None:
        """The jaw faces at n grasps at the openings they need, metres; None for parallel jaws."""
        if not isinstance(body, JawBody):
            return None
        excess = np.where(np.isfinite(needed), needed - grasps.widths, 0.0)
        return cls(body, approaches, excess)

    def normals(self, grasps: ContactPairs) -> Floats:
        """Outward normals (n, 2, 3) of what fits the faces, for as many copies of each grasp."""
        copies = len(grasps) // max(len(self.excess), 1)
        excess = np.repeat(self.excess, copies)
        approaches = np.repeat(self.approaches, copies, axis=0)
        angles = self.body.model.angle_at(grasps.widths + excess)
        return face_normals(grasps.axes, approaches, angles)


def robust_ferrari_canny(
    caster: RayCaster,
    grasps: ContactPairs,
    com: Floats,
    opening: float,
    *,
    quality: Quality,
    robust: Robust,
    rng: np.random.Generator,
    faces: JawFaces | None = None,
    spread: Spread = SPREAD,
) -> tuple[Floats, Floats, Floats]:
    """Mean and deviation of the quality of n grasps over perturbed copies, and the share above 0.

    The open fingers close again; a copy counts as 0 if they start inside or meet nothing.
    """
    copies = len(grasps) * robust.samples
    centers, axes = _disturb(grasps, com, robust.samples, spread, rng)
    contacts, touching = close_fingers(caster, centers, axes, opening)
    coms = com + rng.normal(0, spread.com_sigma, (copies, 3))
    friction = np.maximum(rng.normal(quality.friction, spread.friction_sigma, copies), 0)

    def rated(normals: Floats) -> Floats:
        return ferrari_canny(
            contacts.points[touching],
            normals[touching],
            axes[touching],
            coms[touching],
            friction=friction[touching],
            torque_scaling=ROBUST_TORQUE_SCALING,
            finger_radius=quality.finger_radius,
        )

    values = np.zeros(copies)
    values[touching] = rated(contacts.normals)
    if faces is not None:
        values[touching] = np.minimum(values[touching], rated(faces.normals(contacts)))
    table = values.reshape(len(grasps), robust.samples)
    return table.mean(axis=1), table.std(axis=1), (table > 0).mean(axis=1)


def close_fingers(
    caster: RayCaster, centers: Floats, axes: Floats, opening: float
) -> tuple[ContactPairs, NDArray[np.bool_]]:
    """Contacts of fingers closed from half an opening, m, and where both start outside and meet."""
    directions = np.stack([axes, -axes], axis=1)
    starts = centers[:, None] - opening / 2 * directions
    hits = caster.first_hits(starts.reshape(-1, 3), directions.reshape(-1, 3))
    distances = hits.distances.reshape(-1, 2)
    touching = np.asarray((hits.entering.reshape(-1, 2) & (distances <= opening)).all(axis=1))
    travel = np.where(touching[:, None], distances, 0.0)
    points = starts + travel[..., None] * directions
    return ContactPairs(points, hits.normals.reshape(-1, 2, 3), axes), touching


def _disturb(
    grasps: ContactPairs, com: Floats, samples: int, spread: Spread, rng: np.random.Generator
) -> tuple[Floats, Floats]:
    """Centers and axes of the copies, grasp by grasp: hands move back instead of the mesh."""
    copies = len(grasps) * samples

    def normal(sigma: float) -> Floats:
        return rng.normal(0, sigma, (copies, 3))

    def turn(sigma: float) -> Rotation:
        return Rotation.from_rotvec(normal(sigma))

    centers = np.repeat(grasps.centers, samples, axis=0)
    centers += normal(spread.grasp_translation_sigma)
    axes = turn(spread.grasp_rotation_sigma).apply(np.repeat(grasps.axes, samples, axis=0))
    shift = normal(spread.object_translation_sigma)
    back = turn(spread.object_rotation_sigma).inv()
    return back.apply(centers - shift - com) + com, back.apply(axes)


def face_normals(axes: Floats, approaches: Floats, angles: Floats) -> Floats:
    """Outward normals (n, 2, 3) of objects that fit between jaws at angles (n,), radians."""
    along = np.einsum("nk,nk->n", approaches, axes)[:, None] * axes
    ahead = approaches - along
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    cosine, sine = np.cos(angles / 2)[:, None], np.sin(angles / 2)[:, None]
    return np.stack([-cosine * axes - sine * ahead, cosine * axes - sine * ahead], axis=1)

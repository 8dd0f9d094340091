"""Where a moving jaw and a fixed one face each other, on solids of the shapes of their links."""

from contextlib import suppress
from typing import NamedTuple

import mujoco
import numpy as np
import trimesh
from scipy.spatial import QhullError

from egad._util.arrays import Flags, Floats
from egad.errors import RejectedError, UserError
from egad.geometry import RayCaster, spread, wind_outwards
from egad.grippers.description import shape_surfaces
from egad.grippers.fingers import snapped
from egad.grippers.mechanism import Mechanism
from egad.grippers.tree import body_name

POSITIONS = 17  # of the joint, at which faces are compared
SKIN = 1e-6  # metres in front of a face, where rays start
SPACING = 0.002  # metres between the points on a jaw that look out
SAMPLES = 8000  # of these points at most, each for the same area
FACING = np.cos(np.radians(30.0))  # how far two faces may turn away from each other
ONWARDS = np.cos(np.radians(50.0))  # how far a face may turn away from the way it moves
TILT = np.cos(np.radians(60.0))  # how far faces may tilt along the hinge
ALIKE = np.cos(np.radians(5.0))  # faces that turn less belong to one face, apart from steps
NEAR = 1e-3  # metres: the nearer two faces come to each other, the more they count
DISTAL = 0.4  # of the longest lever: whatever is nearer to the hinge is its bearing
ROUNDING = 0.04  # of directions that are compared
MIN_AREA = 2e-6  # square metres that face each other
SLIDE = mujoco.mjtJoint.mjJNT_SLIDE


class Facing(NamedTuple):
    """How two jaws face each other."""

    axis: Floats  # normal of the fixed jaw's inner face, to the other, in the frame of the palm
    normal: Floats  # normal of the moving jaw's inner face, in the frame of its link
    closing: float  # 1 if the jaw closes while the position of its joint grows, else -1
    points: Floats  # (n, 3) of the fixed jaw's face, in the frame of the palm, metres


def solids_of(model: mujoco.MjModel, body: int) -> list[trimesh.Trimesh]:
    """The collision shapes of a link in its frame; open surfaces become their convex hull."""
    solids = []
    for points, faces in shape_surfaces(model, body):
        with suppress(QhullError):  # it is flat, and touches nothing
            try:
                mesh = trimesh.Trimesh(points, faces) if len(faces) else _hull(points)
                solids.append(wind_outwards(mesh))
            except RejectedError:
                solids.append(_hull(points))
    return solids


def find_facing(mechanism: Mechanism, body: int, moving: RayCaster, fixed: RayCaster) -> Facing:
    """The faces with which a jaw that moves closes against one that does not.

    Faces that the jaw itself hides from the other one, such as those of its ribs and cavities, do
    not count. A face is taken as if it did not tilt along a hinge, or from the way that a jaw
    slides: so the sides of a groove have the direction of its edges. The surfaces are in the frames
    of the jaw and of the palm. Raises `UserError` if they never face each other.
    """
    samples = spread(moving.mesh, SPACING)
    counts = np.bincount(samples.faces, minlength=len(moving.areas))
    sums = np.cumsum((moving.areas / np.maximum(counts, 1))[samples.faces])
    n = min(SAMPLES, len(sums))
    rows = np.minimum(np.searchsorted(sums, sums[-1] * (np.arange(n) + 0.5) / n), len(sums) - 1)
    area, points = float(sums[-1]) / n, (samples.points[rows], samples.normals[rows])
    low, high = mechanism.ranges()[0]
    looks = [
        _looks(mechanism, body, position, *points, moving, fixed)
        for position in np.linspace(low, high, POSITIONS)
    ]
    ways, faces, met, own, gaps = map(np.concatenate, zip(*looks, strict=True))
    closing = float(np.sign(ways.sum()))
    if area * (ways == closing).sum() < MIN_AREA or closing == 0:
        raise UserError(
            f"its jaws never face each other: no face of the moving link "
            f"{body_name(mechanism.model, body)} closes against a fixed one"
        )
    faces, met, own, gaps = (each[ways == closing] for each in (faces, met, own, gaps))
    axis, alike = _prevailing(faces, 1 / (gaps + NEAR))
    normal, _ = _prevailing(own[alike], 1 / (gaps[alike] + NEAR))
    return Facing(axis, normal, closing, met[alike])


def _hull(points: Floats) -> trimesh.Trimesh:
    hull: trimesh.Trimesh = trimesh.convex.convex_hull(points)
    return hull


class _Looks(NamedTuple):
    """What k points of a moving jaw see: which way the joint moves them there, and how far away."""

    ways: Floats
    faces: Floats
    points: Floats
    own: Floats
    gaps: Floats


def _looks(
    mechanism: Mechanism,
    body: int,
    position: float,
    points: Floats,
    normals: Floats,
    moving: RayCaster,
    fixed: RayCaster,
) -> _Looks:
    """What the points see that look at a face that looks back, with nothing in between."""
    positions = mechanism.follow(np.array([position]), mechanism.model.qpos0)
    placement = mechanism.placement(positions)
    turn, place = placement.turns[body], placement.places[body]
    joint = int(mechanism.model.body_jntadr[body])
    axis, slides = mechanism.axis(joint, positions), mechanism.model.jnt_type[joint] == SLIDE
    there, ahead = points @ turn.T + place, _upright(normals @ turn.T, axis, slides)
    velocities, levers = mechanism.velocities(positions, body, there)
    speeds = np.einsum("nk,nk->n", velocities, ahead)
    rows = np.flatnonzero(
        (np.abs(speeds) > ONWARDS * np.linalg.norm(velocities, axis=1))
        & (np.einsum("nk,nk->n", normals @ turn.T, ahead) > TILT)
        & (levers >= DISTAL * levers.max())
    )
    there, ahead = there[rows], np.ascontiguousarray(ahead[rows])
    starts = there + SKIN * normals[rows] @ turn.T
    hits = fixed.first_hits(starts, ahead)
    faces = _upright(hits.normals, axis, slides)
    seen = hits.entering & (np.einsum("nk,nk->n", faces, ahead) < -FACING)
    seen &= np.einsum("nk,nk->n", faces, hits.normals) > TILT
    own = moving.first_hits((starts[seen] - place) @ turn, ahead[seen] @ turn)
    inside = np.isfinite(own.distances) & ~own.entering
    seen[seen] = ~inside & (own.distances > hits.distances[seen])
    met = there[seen] + hits.distances[seen, None] * ahead[seen]
    return _Looks(
        np.sign(speeds[rows[seen]]), faces[seen], met, ahead[seen] @ turn, hits.distances[seen]
    )


def _upright(normals: Floats, axis: Floats, slides: bool) -> Floats:
    """Unit vectors without their part along a hinge, or only with that along a sliding joint."""
    along = (normals @ axis)[:, None] * axis
    across = along if slides else normals - along
    return np.asarray(across / np.maximum(np.linalg.norm(across, axis=1, keepdims=True), SKIN))


def _prevailing(normals: Floats, weights: Floats) -> tuple[Floats, Flags]:
    """The direction that most of some unit vectors have, and which."""
    candidates = np.unique(np.round(normals / ROUNDING), axis=0)
    candidates /= np.linalg.norm(candidates, axis=1, keepdims=True)
    near = (normals @ candidates.T > ALIKE).T
    alike = near[int(np.argmax(near @ weights))]
    mean = np.average(normals[alike], axis=0, weights=weights[alike])
    return snapped(mean / np.linalg.norm(mean)), alike

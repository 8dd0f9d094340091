"""Antipodal grasps of a parallel-jaw gripper on the surface of a mesh.

The rules are those of Dex-Net's antipodal sampler as EGAD used it (Mahler et al., RSS 2017), with
exact ray casting in place of a search along lines in a distance field.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from egad._util.arrays import Floats, Ints
from egad._util.kernels import kernel
from egad.geometry import RayCaster
from egad.grasps.parameters import Sampling

TURN = 0.05 * 2 / np.pi  # metres that a radian of rotation adds to the distance between grasps
CONTACT_TOLERANCE = 1e-6  # of the opening
CANDIDATES, ROUNDS = 200, 10  # axes sampled per round, at least; rounds, at most
APPROACH_CLEARANCE = 0.1  # metres, along which open fingers approach straight


@dataclass(frozen=True)
class ContactPairs:
    """Contacts of n grasps: points and outward normals (n, 2, 3), and axes between (n, 3)."""

    points: Floats
    normals: Floats
    axes: Floats

    @classmethod
    def empty(cls) -> "ContactPairs":
        """No grasps."""
        return cls(np.empty((0, 2, 3)), np.empty((0, 2, 3)), np.empty((0, 3)))

    def __len__(self) -> int:
        return len(self.axes)

    @property
    def centers(self) -> Floats:
        """(n, 3) midpoints of the contacts, metres."""
        return np.asarray(self.points.mean(axis=1))

    @property
    def widths(self) -> Floats:
        """(n,) distances between the contacts, metres."""
        return np.asarray(np.linalg.norm(self.points[:, 1] - self.points[:, 0], axis=1))

    def frames(self, approaches: Floats) -> Floats:
        """(n, 3, 3) unit vectors x, y, z of hands with approaches (n, 3), in rows."""
        return np.stack([self.axes, np.cross(approaches, self.axes), approaches], axis=1)

    def take(self, indices: Ints) -> "ContactPairs":
        """Some of the grasps, in the order given."""
        return ContactPairs(self.points[indices], self.normals[indices], self.axes[indices])


@dataclass(frozen=True)
class SamplingStatistics:
    """Sampling statistics: each candidate is counted once, at the first test that it fails."""

    candidates: int = 0
    too_wide: int = 0  # no opposite surface within the opening
    not_antipodal: int = 0  # the second contact faces too far away from the axis
    blocked: int = 0  # something is in the way of the open fingers
    too_close: int = 0  # too similar to a grasp that was found before

    def __add__(self, other: "SamplingStatistics") -> "SamplingStatistics":
        return SamplingStatistics(
            *(getattr(self, f.name) + getattr(other, f.name) for f in fields(self))
        )

    def __str__(self) -> str:
        causes = [f for f in fields(self) if f.name != "candidates"]
        parts = [f"{getattr(self, f.name)} {f.name.replace('_', ' ')}" for f in causes]
        return f"of {self.candidates} candidates: {', '.join(parts)}"


def sample_contacts(
    caster: RayCaster,
    opening: float,  # metres
    count: int,  # at most; a round samples at least twice as many candidates
    sampling: Sampling,
    rng: np.random.Generator,
    wanted: Callable[[Floats], NDArray[np.bool_]] | None = None,  # which axes (n, 3); None: all
    clearance: float = APPROACH_CLEARANCE,
) -> tuple[ContactPairs, SamplingStatistics]:
    """Find at most `count` well-spread grasps, and sampling statistics.

    First contacts are uniform over the surface; the tangent of the angle between axis and inward
    normal is uniform up to the cone. A finger from the far end of the opening finds the second
    contact; open fingers must then reach both, and approach along one of `approach_directions` for
    the clearance, metres, without a collision (0: off).
    """
    grasps, statistics = ContactPairs.empty(), SamplingStatistics()
    for _ in range(ROUNDS):
        draws = max(CANDIDATES, 2 * count)
        fresh, fate = valid_contacts(caster, opening, draws, sampling, rng, wanted, clearance)
        spread = _keep_apart(grasps, fresh, sampling.spacing)
        grasps = join([grasps, fresh.take(spread)])
        statistics += fate + SamplingStatistics(too_close=len(fresh) - len(spread))
        if len(grasps) >= count:
            break
    return grasps.take(np.arange(min(len(grasps), count))), statistics


def valid_contacts(
    caster: RayCaster,
    opening: float,
    candidates: int,
    sampling: Sampling,
    rng: np.random.Generator,
    wanted: Callable[[Floats], NDArray[np.bool_]] | None = None,
    clearance: float = APPROACH_CLEARANCE,
) -> tuple[ContactPairs, SamplingStatistics]:
    """Sample candidates like `sample_contacts`, and keep all grasps: they are independent draws."""
    areas = np.cumsum(caster.areas)  # points are uniform over the surface
    faces = np.searchsorted(areas, rng.random(candidates) * areas[-1])
    starts: Floats = _points_inside(caster.triangles, faces, rng.random((candidates, 2)))
    normals = caster.normals[faces]
    turn = rng.uniform(0, 2 * np.pi, len(normals))
    lean = rng.uniform(0, sampling.cone, len(normals))  # tangent of the angle to -normal
    axes: Floats = _leaning(normals, lean * np.cos(turn), lean * np.sin(turn))
    if wanted is not None:
        kept = np.flatnonzero(wanted(axes))
        starts, normals, axes = starts[kept], normals[kept], axes[kept]
    return _close(caster, starts, normals, axes, opening, sampling.cone, clearance)


def join(parts: list[ContactPairs]) -> ContactPairs:
    """All grasps of several batches, in order."""
    return ContactPairs(
        np.concatenate([part.points for part in parts]),
        np.concatenate([part.normals for part in parts]),
        np.concatenate([part.axes for part in parts]),
    )


def approach_directions(axes: Floats) -> Floats:
    """Horizontal unit vectors (n, 3) across axes: Dex-Net's angle 0; x for a vertical one."""
    flat = np.stack([axes[:, 1], -axes[:, 0], np.zeros(len(axes))], axis=1)
    length = np.linalg.norm(flat, axis=1, keepdims=True)
    return np.where(length > 1e-9, flat / np.maximum(length, 1e-9), [1.0, 0.0, 0.0])


@kernel()
def _points_inside(triangles: Floats, faces: Ints, along: Floats) -> Floats:
    """Points at fractions of two sides of triangles, folded back from the full parallelogram."""
    points = np.empty((len(faces), 3))
    for i, face in enumerate(faces):
        one, two = along[i]
        if one + two > 1.0:
            one, two = abs(one - 1.0), abs(two - 1.0)
        for k in range(3):
            start = triangles[face, 0, k]
            first, second = triangles[face, 1, k] - start, triangles[face, 2, k] - start
            points[i, k] = start + (one * first + two * second)
    return points


@kernel()
def _leaning(normals: Floats, first: Floats, second: Floats) -> Floats:
    """Unit vectors along -normals plus given amounts of two directions perpendicular to them."""
    axes, one, two = np.empty_like(normals), np.empty(3), np.empty(3)
    for i, normal in enumerate(normals):
        least = np.argmin(np.abs(normal))
        for k in range(3):  # the cross product with this axis
            one[k] = 0.0
        one[(least + 1) % 3], one[(least + 2) % 3] = (
            normal[(least + 2) % 3],
            -normal[(least + 1) % 3],
        )
        length = max(np.sqrt(one[0] ** 2 + one[1] ** 2 + one[2] ** 2), 1e-12)
        for k in range(3):
            one[k] /= length
        for k in range(3):
            m, n = (k + 1) % 3, (k + 2) % 3
            two[k] = normal[m] * one[n] - normal[n] * one[m]
        length = 0.0
        for k in range(3):
            axes[i, k] = first[i] * one[k] + second[i] * two[k] - normal[k]
            length += axes[i, k] ** 2
        for k in range(3):
            axes[i, k] /= np.sqrt(length)
    return axes


def _close(
    caster: RayCaster,
    starts: Floats,
    normals: Floats,
    axes: Floats,
    opening: float,
    cone: float,
    clearance: float,
) -> tuple[ContactPairs, SamplingStatistics]:
    """Close fingers along the axes, and keep the grasps that touch at the starts."""
    far = starts + opening * axes
    hits = caster.first_hits(far, -axes)
    fits = hits.entering & (hits.distances < opening)
    ends = far - np.where(fits, hits.distances, 0.0)[:, None] * axes
    cosine = np.einsum("nk,nk->n", hits.normals, axes)
    antipodal = fits & (cosine * np.sqrt(1 + cone**2) >= 1)
    chosen = np.flatnonzero(antipodal)
    candidates = ContactPairs(
        np.stack([starts, ends], axis=1), np.stack([normals, hits.normals], axis=1), axes
    ).take(chosen)
    free = _fingers_free(caster, candidates, opening, clearance)
    statistics = SamplingStatistics(
        candidates=len(axes),
        too_wide=int(np.sum(~fits)),
        not_antipodal=int(np.sum(fits & ~antipodal)),
        blocked=int(np.sum(~free)),
    )
    return candidates.take(np.flatnonzero(free)), statistics


def _fingers_free(
    caster: RayCaster, grasps: ContactPairs, opening: float, clearance: float
) -> NDArray[np.bool_]:
    """Whether the open fingers reach their positions, and from there the contacts."""
    half = opening / 2 * grasps.axes
    left, right = grasps.centers - half, grasps.centers + half
    travel = (opening - grasps.widths) / 2
    touched = caster.first_hits(left, grasps.axes)
    reached = np.abs(touched.distances - travel) <= CONTACT_TOLERANCE * opening
    free = np.asarray(reached & touched.entering)
    away = -approach_directions(grasps.axes)
    for finger in (left, right) if clearance > 0 else ():
        chosen = np.flatnonzero(free)
        free[chosen] = ~caster.obstructed(finger[chosen], away[chosen], clearance)
    return free


def _keep_apart(old: ContactPairs, new: ContactPairs, spacing: float) -> Ints:
    """Which new grasps, taken in order, are at least `spacing` from all that are kept."""
    both = join([old, new])
    kept: Ints = _spread(both.centers, both.axes, len(old), spacing)
    return kept


@kernel()
def _spread(centers: Floats, axes: Floats, old: int, spacing: float) -> Ints:
    kept = np.arange(len(centers))
    count = old
    for i in range(old, len(centers)):
        apart = True
        for place in range(count):
            if _gap(centers, axes, i, kept[place], spacing) < spacing:
                apart = False
                break
        if apart:
            kept[count] = i
            count += 1
    return kept[old:count] - old


@kernel(inline="always")
def _gap(centers: Floats, axes: Floats, i: int, j: int, spacing: float) -> float:
    """Distance between two grasps; without rotation if their centers are `spacing` apart."""
    square = 0.0
    for k in range(3):
        square += (centers[i, k] - centers[j, k]) ** 2
    gap: float = np.sqrt(square)
    if gap >= spacing:
        return gap
    cosine = 0.0
    for k in range(3):
        cosine += axes[i, k] * axes[j, k]
    gap += TURN * np.arccos(min(abs(cosine), 1.0))
    return gap

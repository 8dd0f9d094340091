"""The surface that fingers can touch, and how deep it lies in convex parts."""

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
import trimesh
from numpy.typing import NDArray

from egad._util.arrays import Flags, Floats, dot_products
from egad._util.kernels import kernel
from egad.geometry.hulls import Hull, hull_of
from egad.geometry.rays import RayCaster
from egad.random import generator

FINGER = 0.01  # metres, the thickness of a finger: 99.6 % of labelled contacts have as much space
START = 1e-4  # metres in front of the surface, where the rays start so as not to meet it
SAMPLES = 16000  # on the whole surface; half as many miss small necks
MAX_BURIED = 0.01  # of the touchable surface: may lie deeper in parts than their deviation
FACING = 0.3  # cosine: planes turned further away from a point's normal do not cover it


class Touchable(NamedTuple):
    """Points of a surface, (n, 3) in metres, and the outward unit normals there, (n, 3)."""

    points: Floats
    normals: Floats

    def where(self, chosen: NDArray[Any]) -> "Touchable":
        """Some of the points, by flags, (n,), or indices."""
        return Touchable(self.points[chosen], self.normals[chosen])

    def and_more(self, others: "Touchable") -> "Touchable":
        """These points and others."""
        return Touchable(*map(np.concatenate, zip(self, others, strict=True)))


def touchable_points(mesh: trimesh.Trimesh, purpose: str) -> Touchable:
    """At most 16,000 points of equal area with 10 mm of free space along the normal (ours)."""
    caster = RayCaster(mesh)
    rng = generator(0, "touchable points", purpose)
    sums = np.cumsum(caster.areas)
    areas = sums[-1] * (np.arange(SAMPLES) + rng.random(SAMPLES)) / SAMPLES
    faces = np.minimum(np.searchsorted(sums, areas), len(sums) - 1)
    far, along = np.sqrt(rng.random(SAMPLES)), rng.random(SAMPLES)
    weights = np.stack([1 - far, far * (1 - along), far * along], axis=1)
    points = np.einsum("nk,nki->ni", weights, caster.triangles[faces])
    normals = caster.normals[faces]
    free = ~caster.obstructed(points + START * normals, normals, FINGER)
    return Touchable(points[free], normals[free])


@kernel()
def depths(points: Floats, planes: Floats) -> Floats:
    """How far points (n, 3) lie below the outermost of m planes (m, 4), (n,); negative outside."""
    found = np.full(len(points), np.inf)
    for i in range(len(points)):
        for j in range(len(planes)):
            below = -planes[j, 3]
            for k in range(3):
                below -= points[i, k] * planes[j, k]
            found[i] = min(found[i], below)
    return found


def facing_depths(touchable: Touchable, planes: Floats) -> Floats:
    """Depths of points below planes that face the same way, (n, m); infinite below the others."""
    facing = dot_products(touchable.normals, planes[:, :3]) > FACING
    below = -(dot_products(touchable.points, planes[:, :3]) + planes[:, 3])
    return np.where(facing, below, np.inf)


@kernel()
def deeper_points(
    points: Floats, normals: Floats, planes: Floats, depth: float, facing_depth: float
) -> Flags:
    """Which of n points lie deeper than `depth`, and `facing_depth` below planes that they face."""
    found = np.zeros(len(points), np.bool_)
    for i in range(len(points)):
        deep = True
        for j in range(len(planes)):
            below, facing = -planes[j, 3], 0.0
            for k in range(3):
                below -= points[i, k] * planes[j, k]
                facing += normals[i, k] * planes[j, k]
            if below <= depth or (facing > FACING and below <= facing_depth):
                deep = False
                break
        found[i] = deep
    return found


def buried_share(mesh: trimesh.Trimesh, parts: Iterable[trimesh.Trimesh], depth: float) -> float:
    """Share of the touchable surface that lies deeper than `depth` in a convex part (ours)."""
    hulls = (hull_of(np.asarray(part.vertices)) for part in parts)
    return share_within(touchable_points(mesh, "check").points, hulls, depth)


def share_within(points: Floats, hulls: Iterable[Hull], depth: float) -> float:
    """Share of points (n, 3) that lie deeper than `depth` in any of some hulls."""
    buried = np.zeros(len(points), dtype=np.bool_)
    for hull in hulls:
        near = np.flatnonzero(within_box(points, hull.points))
        buried[near] |= depths(points[near], hull.planes) > depth
    return float(buried.mean()) if len(buried) else 0.0


def within_box(points: Floats, corners: Floats) -> Flags:
    """Whether points (n, 3) lie in the axis-aligned box of others, (n,)."""
    inside = np.ones(len(points), dtype=np.bool_)
    for along, edge in zip(points.T, corners.T, strict=True):
        inside &= (along >= edge.min()) & (along <= edge.max())
    return inside

"""The best plane to cut a solid along, so that both sides are close to their hulls."""

from itertools import product
from typing import NamedTuple

import numpy as np

from egad._util.arrays import Floats, Ints, dot_products
from egad.geometry.hulls import hull_of, least_volume
from egad.geometry.manifold import Solid, arrays
from egad.geometry.touchable import depths

Plane = tuple[Floats, float]  # unit normal, distance from the origin

FLUSH_PLANES = 4  # the planes of this many of the largest faces at the deepest point are tried
GRAZE = 1e-3  # of the longest side: thinner slices are not cut off
COARSENESS = 0.01  # of the longest side: the planes are tried on a solid simplified by as much
EVEN_PLANES = 3  # per coordinate axis
# Fraction of the volume of a hull beyond its solid. A cut that gains less is not worth it: a ring
# could be cut into ever thinner rings, and the hull of each would still fill its hole.
MIN_GAIN = 1e-3


class _Cut(NamedTuple):
    """A cut, and the volumes of the hull before it and of both hulls after it."""

    plane: Plane
    before: float
    after: float


# the axes, face diagonals and space diagonals of a cube, (13, 3)
_HALF = np.array([v for v in product((0, 1, -1), repeat=3) if v > (0, 0, 0)], dtype=np.float64)
DIRECTIONS = _HALF / np.linalg.norm(_HALF, axis=1, keepdims=True)


def best_plane(solid: Solid, planes_of_hull: Floats) -> Plane:
    """The plane whose two sides have the smallest hulls, or that halves a ring well (ours)."""
    cut = _best_cut(solid, planes_of_hull)
    if cut.before - cut.after > MIN_GAIN * (cut.before - solid.volume()):
        return cut.plane
    halving = [_halving(solid, axis) for axis in range(3)]
    return min(halving, key=lambda each: volume_after(solid, each))


def middle_plane(solid: Solid) -> Plane:
    """The plane that halves the longest side of a solid's axis-aligned box."""
    low, high = np.reshape(solid.bounding_box(), (2, 3))
    return _halving(solid, int((high - low).argmax()))


def _halving(solid: Solid, axis: int) -> Plane:
    low, high = np.reshape(solid.bounding_box(), (2, 3))
    return np.eye(3)[axis], float(low[axis] + high[axis]) / 2


def volume_after(solid: Solid, plane: Plane) -> float:
    """Volume of hulls after a cut and the best cut of each half; infinite if a half is empty."""
    halves = solid.split_by_plane(tuple(plane[0]), plane[1])
    if any(half.is_empty() for half in halves):  # the plane met a needle without volume
        return np.inf
    volume = 0.0
    for half in halves:
        hull = hull_of(arrays(half)[0])
        if len(hull.planes):
            cut = _best_cut(half, hull.planes)
            volume += min(cut.before, cut.after)
    return volume


def _best_cut(solid: Solid, planes_of_hull: Floats) -> _Cut:
    """The plane whose sides have the smallest hulls: of infinite volume if all planes miss."""
    vertices, faces = arrays(solid)
    size = float(np.ptp(vertices, axis=0).max())
    planes = _planes(vertices, faces, depths(vertices, planes_of_hull))
    simple = solid.simplify(COARSENESS * size)
    if not simple.is_empty():
        vertices, faces = arrays(simple)
    sides = _sides(vertices, faces, planes, GRAZE * size)
    volumes = [sum(map(least_volume, both)) if both else np.inf for both in sides]
    number = int(np.argmin(volumes))
    return _Cut(planes[number], least_volume(vertices), volumes[number])


def _sides(vertices: Floats, faces: Ints, planes: list[Plane], least: float) -> list[list[Floats]]:
    """Points with the hulls of both sides of each cut; none if one is thinner than `least`."""
    edges = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    starts, ends = edges[edges[:, 0] < edges[:, 1]].T  # each once
    normals, offsets = (np.array(each) for each in zip(*planes, strict=True))
    heights = dot_products(normals, vertices) - offsets[:, None]
    above = heights > 0
    plane, edge = np.nonzero(above[:, starts] != above[:, ends])
    first, second = starts[edge], ends[edge]
    high, low = heights[plane, first], heights[plane, second]
    part = (high / (high - low))[:, None]
    rims = (1 - part) * vertices[first] + part * vertices[second]
    ends_of_rims = np.searchsorted(plane, np.arange(1, len(planes)))
    cuts = np.minimum(heights.max(axis=1), -heights.min(axis=1)) > least
    return [
        [np.concatenate([vertices[side], rim]) for side in (flags, ~flags)] if cut else []
        for flags, rim, cut in zip(above, np.split(rims, ends_of_rims), cuts, strict=True)
    ]


def _planes(vertices: Floats, faces: Ints, depths: Floats) -> list[Plane]:
    place = int(depths.argmax())
    deepest = vertices[place]
    normals = [*DIRECTIONS, *_flush(vertices, faces[(faces == place).any(axis=1)])]
    offsets = dot_products(np.array(normals), deepest[None])[:, 0].tolist()
    through = list(zip(normals, offsets, strict=True))
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    steps = np.arange(1, EVEN_PLANES + 1) / (EVEN_PLANES + 1)
    even = [
        (normal, float(low[axis] + step * (high[axis] - low[axis])))
        for axis, normal in enumerate(np.eye(3))
        for step in steps
    ]
    return through + even


def _flush(vertices: Floats, faces: Ints) -> Floats:
    """Normals of the largest of some faces, (n, 3): cuts along them open a notch."""
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    areas = np.cross(b - a, c - a)
    sizes = np.linalg.norm(areas, axis=1)
    largest = np.argsort(-sizes, kind="stable")[:FLUSH_PLANES]
    normals: Floats = (
        areas[largest] / np.maximum(sizes[largest], np.finfo(np.float64).tiny)[:, None]
    )
    return normals

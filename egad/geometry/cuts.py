"""The plane that a solid is best cut along, so that both sides are close to their hulls."""

from itertools import product

import numpy as np
from numpy.typing import NDArray

from egad.geometry.hulls import hull_of, least_volume
from egad.geometry.manifold import Solid, arrays
from egad.geometry.touchable import depths

Floats = NDArray[np.float64]
Plane = tuple[Floats, float]  # unit normal, distance from the origin

FLUSH_PLANES = 4  # largest faces at the deepest point, whose planes are tried
GRAZE = 1e-3  # of the longest side: thinner is nothing to cut off
EVEN_PLANES = 3  # a coordinate axis


def _directions() -> Floats:
    """The axes, face diagonals and space diagonals of a cube, (13, 3)."""
    half = np.array([v for v in product((0, 1, -1), repeat=3) if v > (0, 0, 0)], dtype=np.float64)
    unit: Floats = half / np.linalg.norm(half, axis=1, keepdims=True)
    return unit


DIRECTIONS = _directions()


def best_plane(solid: Solid, planes_of_hull: Floats) -> Plane:
    """The plane whose two sides have the smallest hulls (ours).

    The planes tried go through the point that lies deepest below the hull, in 13 directions and
    along the faces there, and in even steps along the axes.

    Args:
        solid: Which is not convex.
        planes_of_hull: Outward unit normals and offsets, (m, 4).
    """
    vertices, faces = arrays(solid)
    edges = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    edges = edges[edges[:, 0] < edges[:, 1]]  # each once
    planes = _planes(vertices, faces, depths(vertices, planes_of_hull))
    least = GRAZE * float(np.ptp(vertices, axis=0).max())
    sides = [_sides(vertices, edges, plane, least) for plane in planes]
    return planes[_smallest(sides)]


def middle_plane(solid: Solid) -> Plane:
    """The plane that halves the longest side of a solid's axis-aligned box."""
    low, high = np.reshape(solid.bounding_box(), (2, 3))
    axis = int((high - low).argmax())
    return np.eye(3)[axis], float(low[axis] + high[axis]) / 2


def _smallest(sides: list[list[Floats]]) -> int:
    """Which sides have the smallest hulls: bounds first, then volumes while they can matter."""
    bounds = [sum(map(least_volume, both)) if both else np.inf for both in sides]
    best, least = 0, np.inf
    for number in np.argsort(bounds, kind="stable").tolist():
        if bounds[number] >= least:
            break
        volume = sum(hull_of(side).volume for side in sides[number])
        if volume < least:
            best, least = number, volume
    return best


def _sides(vertices: Floats, edges: NDArray[np.int64], plane: Plane, least: float) -> list[Floats]:
    """Points whose hulls are those of the two sides of a cut.

    There are none if it misses, or cuts off something thinner than `least`.
    """
    normal, offset = plane
    heights = vertices @ normal - offset
    above = heights > 0
    if min(heights.max(), -heights.min()) <= least:
        return []
    first, second = edges[above[edges[:, 0]] != above[edges[:, 1]]].T
    part = (heights[first] / (heights[first] - heights[second]))[:, None]
    rim = (1 - part) * vertices[first] + part * vertices[second]
    return [np.concatenate([vertices[side], rim]) for side in (above, ~above)]


def _planes(vertices: Floats, faces: NDArray[np.int64], depths: Floats) -> list[Plane]:
    place = int(depths.argmax())
    deepest = vertices[place]
    normals = [*DIRECTIONS, *_flush(vertices, faces[(faces == place).any(axis=1)])]
    through = [(normal, float(normal @ deepest)) for normal in normals]
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    steps = np.arange(1, EVEN_PLANES + 1) / (EVEN_PLANES + 1)
    even = [
        (normal, float(low[axis] + step * (high[axis] - low[axis])))
        for axis, normal in enumerate(np.eye(3))
        for step in steps
    ]
    return through + even


def _flush(vertices: Floats, faces: NDArray[np.int64]) -> Floats:
    """Normals of the largest of some faces, (n, 3): cuts along them open a notch."""
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    areas = np.cross(b - a, c - a)
    sizes = np.linalg.norm(areas, axis=1)
    largest = np.argsort(-sizes, kind="stable")[:FLUSH_PLANES]
    normals: Floats = (
        areas[largest] / np.maximum(sizes[largest], np.finfo(np.float64).tiny)[:, None]
    )
    return normals

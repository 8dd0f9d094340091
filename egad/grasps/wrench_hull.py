"""How far the origin lies inside the convex hull of a few points in six dimensions.

The hull is built only where it matters: the facet nearest to the origin is expanded until no point
lies beyond it. Facets are simplices; neighbor k of a facet lies opposite to its vertex k. The
plane of a new facet is a convex combination of the planes of the two facets that meet in its
horizon ridge: a point that is coplanar with an old facet continues exactly that plane, so coplanar
points need no special case.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from egad._util.kernels import kernel

TOLERANCE = 1e-12  # of the largest coordinate: points nearer to a plane lie on it
_FACETS = 4096
_SLOTS_LOG2 = 10
_SLOTS = 1 << _SLOTS_LOG2
_OPEN_RIDGES = _SLOTS // 6  # every ridge of the horizon opens five others
_HASH_FACTOR = 0x1E3779B97F4A7C15


class Workspace(NamedTuple):
    """Memory for one hull, reused for the next one."""

    vertices: NDArray[np.int64]
    neighbors: NDArray[np.int64]
    normals: NDArray[np.float64]
    offsets: NDArray[np.float64]
    heights: NDArray[np.float64]  # of the new point above each facet
    seen: NDArray[np.int64]
    stack: NDArray[np.int64]  # facets that the new point lies beyond
    horizon: NDArray[np.int64]  # facet and vertex opposite to the ridge
    free: NDArray[np.int64]
    ridges: NDArray[np.int64]  # bit masks of vertices
    ends: NDArray[np.int64]  # facet and vertex that wait at this ridge for a neighbor


@kernel()
def _workspace() -> Workspace:
    return Workspace(
        np.empty((_FACETS, 6), np.int64),
        np.empty((_FACETS, 6), np.int64),
        np.empty((_FACETS, 6)),
        np.empty(_FACETS),
        np.empty(_FACETS),
        np.empty(_FACETS, np.int64),
        np.empty(_FACETS, np.int64),
        np.empty((_OPEN_RIDGES, 2), np.int64),
        np.empty(_FACETS, np.int64),
        np.empty(_SLOTS, np.int64),
        np.empty((_SLOTS, 2), np.int64),
    )


def depths(points: NDArray[np.float64], floor: float = 0.0) -> NDArray[np.float64]:
    """Distance from the origin to the boundary of each hull of n sets of at most 62 points, (n,).

    0 where the origin is not strictly inside; a depth below `floor` may be a bound below it.
    """
    result: NDArray[np.float64] = _depths(np.ascontiguousarray(points, dtype=float), floor)
    for i in np.flatnonzero(np.isnan(result)):
        result[i] = slow_depth(points[i])
    return result


def slow_depth(points: NDArray[np.float64]) -> float:
    """As `depths`, for one set of points, by Qhull, which copes with any input."""
    try:
        offset = -float(ConvexHull(points).equations[:, -1].max())
    except QhullError:  # flat
        return 0.0
    return offset if offset > TOLERANCE * np.abs(points).max() else 0.0


@kernel()
def _depths(points: NDArray[np.float64], floor: float) -> NDArray[np.float64]:
    space = _workspace()
    result = np.empty(len(points))
    for i in range(len(points)):
        result[i] = _depth(points[i], space, floor)
    return result


@kernel()
def _depth(points: NDArray[np.float64], space: Workspace, floor: float) -> float:
    """The smallest facet offset or 0, or an upper bound below the floor; NaN if the hull fails."""
    tolerance = TOLERANCE * np.abs(points).max()
    if not _start(points, space, tolerance):
        return 0.0
    used, free = 7, 0
    for _ in range(4 * len(points)):
        nearest = _nearest(space.offsets, used)
        offset = space.offsets[nearest]
        apex, height = _farthest(points, space.normals[nearest])
        if height < floor:  # the hull reaches no farther in this direction
            return max(height, 0.0)
        if height - offset <= tolerance:
            return offset if offset > tolerance else 0.0
        hidden, edges = _find_horizon(points[apex], nearest, used, space, tolerance)
        if edges > _OPEN_RIDGES or used + edges > _FACETS:
            return np.nan
        used, free = _raise_facets(apex, edges, used, free, space, tolerance)
        if free < 0:
            return np.nan
        for i in range(hidden):
            space.offsets[space.stack[i]] = np.inf
            space.free[free + i] = space.stack[i]
        free += hidden
    return np.nan


@kernel()
def _start(points: NDArray[np.float64], space: Workspace, tolerance: float) -> bool:
    """Make a simplex of seven far-apart points; False if all points are in one hyperplane."""
    chosen = np.zeros(7, np.int64)
    left = points - points[0]
    unit = np.empty(6)
    for k in range(1, 7):
        longest = 0.0
        for i in range(len(left)):
            square = _dot(left[i], left[i])
            if square > longest:
                chosen[k], longest = i, square
        if not longest > tolerance**2:  # NaN counts as flat
            return False
        unit[:] = left[chosen[k]]
        for i in range(len(left)):
            along = _dot(left[i], unit) / longest
            for j in range(6):
                left[i, j] -= along * unit[j]
    gradients = np.zeros((7, 6))  # of the barycentric coordinates
    gradients[1:] = np.linalg.inv(points[chosen[1:]] - points[0]).T
    gradients[0] = -gradients[1:].sum(axis=0)
    for k in range(7):
        space.normals[k] = -gradients[k] / np.sqrt(_dot(gradients[k], gradients[k]))
        for j in range(6):
            space.vertices[k, j] = chosen[j if j < k else j + 1]
            space.neighbors[k, j] = j if j < k else j + 1
        space.offsets[k] = _dot(space.normals[k], points[space.vertices[k, 0]])
    return True


@kernel()
def _find_horizon(
    apex: NDArray[np.float64], first: int, used: int, space: Workspace, tolerance: float
) -> tuple[int, int]:
    """Count the facets that the apex lies beyond (stack) and the edges of the region (horizon)."""
    for f in range(used):
        space.heights[f] = _dot(space.normals[f], apex) - space.offsets[f]
        space.seen[f] = 0
    space.stack[0], space.seen[first] = first, 1
    hidden, done, edges = 1, 0, 0
    while done < hidden:
        facet = space.stack[done]
        done += 1
        for k in range(6):
            other = space.neighbors[facet, k]
            if space.heights[other] <= tolerance:
                if edges < _OPEN_RIDGES:
                    space.horizon[edges, 0], space.horizon[edges, 1] = facet, k
                edges += 1
            elif not space.seen[other]:
                space.stack[hidden], space.seen[other] = other, 1
                hidden += 1
    return hidden, edges


@kernel()
def _raise_facets(
    apex: int, edges: int, used: int, free: int, space: Workspace, tolerance: float
) -> tuple[int, int]:
    """Join the apex to each ridge of the horizon: facets in use, and free; -1 if left open."""
    vertices, neighbors = space.vertices, space.neighbors
    normals, offsets, heights = space.normals, space.offsets, space.heights
    horizon, ridges, ends = space.horizon, space.ridges, space.ends
    ridges[:] = 0
    unmatched = 0
    for e in range(edges):
        old, k = horizon[e, 0], horizon[e, 1]
        other = neighbors[old, k]
        if free > 0:
            free -= 1
            new = space.free[free]
        else:
            new = used
            used += 1
        below = -heights[other]
        if below <= tolerance:
            below = 0.0
        if not _tilt(new, old, other, below, heights[old], normals, offsets):
            return used, -1
        mask = 0
        for j in range(6):
            vertices[new, j] = apex if j == k else vertices[old, j]
            mask |= 1 << vertices[new, j]
            if neighbors[other, j] == old:
                neighbors[other, j] = new
        neighbors[new, k] = other
        for j in range(6):
            if j != k:
                ridge = mask ^ (1 << vertices[new, j])
                unmatched += _match(ridge, new, j, ridges, ends, neighbors)
    return used, free if unmatched == 0 else -1


@kernel()
def _tilt(
    new: int,
    old: int,
    other: int,
    below: float,
    above: float,
    normals: NDArray[np.float64],
    offsets: NDArray[np.float64],
) -> bool:
    """Turn the plane of `old`, which the apex is above, about its ridge to hold the apex."""
    square = 0.0
    for j in range(6):
        value = below * normals[old, j] + above * normals[other, j]
        normals[new, j] = value
        square += value * value
    length = np.sqrt(square)
    if length <= 1e-9 * (below + above):
        return False
    for j in range(6):
        normals[new, j] /= length
    offsets[new] = (below * offsets[old] + above * offsets[other]) / length
    return True


@kernel()
def _match(
    ridge: int,
    facet: int,
    k: int,
    ridges: NDArray[np.int64],
    ends: NDArray[np.int64],
    neighbors: NDArray[np.int64],
) -> int:
    """Link two new facets at their common ridge: 1 for the first of them, -1 for the second."""
    slot = ((ridge * _HASH_FACTOR) >> (64 - _SLOTS_LOG2)) & (_SLOTS - 1)
    while ridges[slot] != 0 and ridges[slot] != ridge:
        slot = (slot + 1) & (_SLOTS - 1)
    if ridges[slot] == 0:
        ridges[slot] = ridge
        ends[slot, 0], ends[slot, 1] = facet, k
        return 1
    neighbors[facet, k] = ends[slot, 0]
    neighbors[ends[slot, 0], ends[slot, 1]] = facet
    return -1


@kernel()
def _nearest(offsets: NDArray[np.float64], used: int) -> int:
    best = 0
    for f in range(1, used):
        if offsets[f] < offsets[best]:
            best = f
    return best


@kernel()
def _farthest(points: NDArray[np.float64], normal: NDArray[np.float64]) -> tuple[int, float]:
    best, height = 0, -np.inf
    for i in range(len(points)):
        value = _dot(points[i], normal)
        if value > height:
            best, height = i, value
    return best, height


@kernel()
def _dot(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    total = 0.0
    for j in range(6):
        total += a[j] * b[j]
    return total

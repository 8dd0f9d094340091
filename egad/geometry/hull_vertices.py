"""Hulls with fewer vertices, and hulls whose faces are moved inwards."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, HalfspaceIntersection, QhullError

from egad._util.arrays import Floats
from egad.geometry.hulls import Hull


def fewer_vertices(hull: Hull, most: int, distance: float, share: float) -> tuple[Hull, bool]:
    """A hull of some of the corners of a hull, and whether its losses are within bounds (ours).

    The corners farthest outside are added repeatedly, until there are `most`, or all others lie
    within `distance` and the lost volume is within `share`.
    """
    chosen = _far_apart(hull.points)
    while True:
        found = ConvexHull(hull.points[chosen])
        beyond = hull.points @ found.equations[:, :3].T + found.equations[:, 3]
        facets, heights = beyond.argmax(axis=1), beyond.max(axis=1)
        is_near = heights.max() <= distance and found.volume >= (1 - share) * hull.volume
        if is_near or len(chosen) >= min(most, len(hull.points)):
            kept = Hull(hull.points[np.sort(chosen)], float(found.volume), found.equations)
            return kept, bool(is_near)
        chosen += _farthest(heights, facets, min(most, len(hull.points)) - len(chosen))


def _farthest(heights: Floats, facets: NDArray[np.int64], most: int) -> list[int]:
    """Indices of points highest above their facets and half as high as any, highest first."""
    order = np.argsort(-heights, kind="stable")
    _, first = np.unique(facets[order], return_index=True)
    leaders = order[np.sort(first)]
    found: list[int] = leaders[heights[leaders] >= heights.max() / 2][:most].tolist()
    return found


def _far_apart(points: Floats) -> list[int]:
    """Indices of four points that span a tetrahedron."""
    first = int(((points - points.mean(axis=0)) ** 2).sum(axis=1).argmax())
    from_first = points - points[first]
    second = int((from_first**2).sum(axis=1).argmax())
    away = np.cross(from_first, from_first[second])
    third = int((away**2).sum(axis=1).argmax())
    fourth = int(np.abs(from_first @ away[third]).argmax())
    return [first, second, third, fourth]


def lower_planes(planes: Floats, by: Floats, inside: Floats) -> Floats | None:
    """Corners (n, 3) of a hull whose faces move inwards `by` (m,); None if `inside` is outside."""
    moved = np.column_stack([planes[:, :3], planes[:, 3] + by])
    try:
        corners = HalfspaceIntersection(moved, inside).intersections
    except QhullError:
        return None
    return corners if np.isfinite(corners).all() else None

"""Convex hulls of points, and merging of hulls that lie close together.

manifold3d finds a hull four times as fast as Qhull, but occasionally misses a point, and with it
several percent of the volume. So manifold3d is used to compare cuts and for lower bounds, and Qhull
decides which hulls are merged.
"""

import heapq
from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

import manifold3d
import numpy as np
import trimesh
from scipy.spatial import ConvexHull, HalfspaceIntersection, QhullError

from egad._util.arrays import Floats, Ints, dot_products
from egad.geometry.manifold import to_mesh

TOUCHING = 1e-6  # of the longest side: boxes this close count as touching
EQUAL = 1e-9  # relative difference of volumes that are the same


class Hull(NamedTuple):
    """A convex hull."""

    points: Floats  # (n, 3) its corners
    volume: float  # its volume
    planes: Floats  # (m, 4) outward unit normals and offsets of faces; @ corner + offset <= 0


def hull_of(points: Floats) -> Hull:
    """The convex hull of points (n, 3); without volume and planes if they lie in one plane."""
    try:
        hull = ConvexHull(points)
    except QhullError:
        return Hull(points, 0.0, np.empty((0, 4)))
    return Hull(points[hull.vertices], float(hull.volume), hull.equations)


def least_volume(points: Floats) -> float:
    """A lower bound of the volume of the hull of points (n, 3), most often the volume itself."""
    return float(manifold3d.Manifold.hull_points(points).volume())


def hull_mesh(hull: Hull) -> trimesh.Trimesh:
    """The surface of a hull that has a volume, wound outwards."""
    solid = manifold3d.Manifold.hull_points(hull.points)
    if abs(solid.volume() - hull.volume) <= EQUAL * hull.volume:
        return to_mesh(solid)
    mesh = trimesh.Trimesh(hull.points, ConvexHull(hull.points).simplices, process=False)
    trimesh.repair.fix_normals(mesh)  # by neighbors: slivers have no normal to go by
    return mesh


def merge_hulls(hulls: Sequence[Hull], allowed: float, fits: Callable[[Hull], bool]) -> list[Hull]:
    """Merge touching hulls, the cheapest first, while all volumes are at most `allowed`."""
    pool = _Pool(hulls)
    total = sum(hull.volume for hull in hulls)
    while candidate := pool.cheapest():
        added, first, second = candidate
        if total + added > allowed:
            break
        if fits(pool.common(first, second)):
            total += added
            pool.join(first, second)
    return [pool.hulls[number] for number in sorted(pool.alive)]


class _Pool:
    """Hulls by number, and a heap of lower bounds of what merging two touching hulls adds."""

    def __init__(self, hulls: Iterable[Hull]) -> None:
        self.hulls: list[Hull] = []
        self.boxes = np.empty((0, 2, 3))
        self.alive: set[int] = set()
        self.heap: list[tuple[float, int, int]] = []
        self._known: dict[tuple[int, int], Hull] = {}
        for hull in hulls:
            self._add(hull)

    def cheapest(self) -> tuple[float, int, int] | None:
        """Added volume and numbers of the best pair of hulls that touch; None if none do."""
        while self.heap:
            bound, first, second = heapq.heappop(self.heap)
            if not self.alive.issuperset((first, second)):
                continue
            added = self.common(first, second).volume - self._apart(first, second)
            if not self.heap or added <= max(bound, self.heap[0][0]):
                return added, first, second
            heapq.heappush(self.heap, (added, first, second))
        return None

    def join(self, first: int, second: int) -> None:
        """Replace two hulls by their common hull."""
        self.alive -= {first, second}
        self._add(self.common(first, second))

    def _add(self, hull: Hull) -> None:
        number = len(self.hulls)
        box = np.array([hull.points.min(axis=0), hull.points.max(axis=0)])
        near = TOUCHING * float(np.ptp(box, axis=0).max())
        apart = (self.boxes[:, 0] > box[1] + near) | (self.boxes[:, 1] < box[0] - near)
        touching = np.flatnonzero(~apart.any(axis=1)).tolist()
        self.hulls.append(hull)
        self.boxes = np.concatenate([self.boxes, box[None]])
        for other in self.alive.intersection(touching):
            bound = least_volume(self._points(other, number)) - self._apart(other, number)
            heapq.heappush(self.heap, (bound, other, number))
        self.alive.add(number)

    def _points(self, first: int, second: int) -> Floats:
        return np.concatenate([self.hulls[first].points, self.hulls[second].points])

    def common(self, first: int, second: int) -> Hull:
        if (first, second) not in self._known:
            self._known[first, second] = hull_of(self._points(first, second))
        return self._known[first, second]

    def _apart(self, first: int, second: int) -> float:
        return self.hulls[first].volume + self.hulls[second].volume


def fewer_vertices(hull: Hull, most: int, distance: float, share: float) -> tuple[Hull, bool]:
    """A hull of some corners, `most` or until losses are small, and whether these are in bounds."""
    chosen = _far_apart(hull.points)
    while True:
        found = ConvexHull(hull.points[chosen])
        beyond = dot_products(hull.points, found.equations[:, :3]) + found.equations[:, 3]
        facets, heights = beyond.argmax(axis=1), beyond.max(axis=1)
        is_near = heights.max() <= distance and found.volume >= (1 - share) * hull.volume
        if is_near or len(chosen) >= min(most, len(hull.points)):
            kept = Hull(hull.points[np.sort(chosen)], float(found.volume), found.equations)
            return kept, bool(is_near)
        chosen += _farthest(heights, facets, min(most, len(hull.points)) - len(chosen))


def _farthest(heights: Floats, facets: Ints, most: int) -> list[int]:
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
    fourth = int(np.abs(dot_products(from_first, away[[third]])).argmax())
    return [first, second, third, fourth]


def lower_planes(planes: Floats, by: Floats, inside: Floats) -> Floats | None:
    """Corners (n, 3) of a hull whose faces move inwards `by` (m,); None if `inside` is outside."""
    moved = np.column_stack([planes[:, :3], planes[:, 3] + by])
    try:
        corners = HalfspaceIntersection(moved, inside).intersections
    except QhullError:
        return None
    return corners if np.isfinite(corners).all() else None

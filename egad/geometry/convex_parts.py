"""Convex parts of a solid, for physics engines that collide only convex bodies."""

import heapq
from collections.abc import Iterator
from itertools import count, product
from typing import NamedTuple

import numpy as np
import trimesh
from numpy.typing import NDArray

from egad.errors import RejectedError
from egad.geometry.checks import ROUNDING, check_mesh
from egad.geometry.hulls import Hull, hull_and_planes, hull_mesh, hull_of, least_volume, merge_hulls
from egad.geometry.manifold import Solid, arrays, is_solid, to_solid, union

Floats = NDArray[np.float64]
Plane = tuple[Floats, float]  # unit normal, distance from the origin

SIMPLIFICATION = 0.005  # of the longest side: finer detail costs time and changes no contact
SLIVER = 1e-6  # of the volume: thinner crumbs have no usable hull
FLUSH_PLANES = 4  # largest faces at the deepest point, whose planes are tried
GRAZE = 1e-3  # of the longest side: thinner is nothing to cut off
EVEN_PLANES = 3  # a coordinate axis
# Cutting goes on to this part of the allowed error; then parts are joined again until it is spent.
OVERCUT = 0.7
LEAST_EXCESS = 0.3  # of the allowed error, for solids that simplification made larger
SPARE = 2  # times as many pieces as parts are allowed are cut at most


class _Piece(NamedTuple):
    """A piece in the heap: the one whose hull adds most volume comes out first."""

    negative_excess: float
    number: int  # of equals, the older one
    solid: Solid
    hull: Hull
    planes: Floats  # of the hull, (n, 4): outward normals and offsets


def _directions() -> Floats:
    """The axes, face diagonals and space diagonals of a cube, (13, 3)."""
    half = np.array([v for v in product((0, 1, -1), repeat=3) if v > (0, 0, 0)], dtype=np.float64)
    unit: Floats = half / np.linalg.norm(half, axis=1, keepdims=True)
    return unit


DIRECTIONS = _directions()


def convex_parts(
    mesh: trimesh.Trimesh, max_parts: int, volume_error: float
) -> list[trimesh.Trimesh]:
    """Convex hulls that together stand for a solid (ours).

    The solid is cut again and again: always the piece whose hull exceeds it by the largest
    volume, at the plane that leaves least. The planes tried go through the point that lies deepest
    below the hull, in 13 directions and along the faces there, and in even steps along the axes.
    Then pieces whose common hull adds least are joined again, which makes good for unlucky cuts.
    Cuts are exact, so nothing of the solid is lost but a simplification by at most 0.5 % of its
    longest side.

    Args:
        mesh: A closed surface, wound either way, in any unit.
        max_parts: Most hulls; reached only by objects that need more.
        volume_error: The hulls may exceed the solid by this fraction of it.

    Returns:
        Convex meshes with outward normals, at least one.

    Raises:
        RejectedError: The mesh does not bound a solid, or has more bodies than `max_parts`.
        UserError: It is not a mesh.
    """
    whole = _solid(mesh)
    volume = abs(float(mesh.volume))
    gained = whole.volume() - volume  # by simplification
    least = LEAST_EXCESS * volume_error * volume
    pieces = _split(whole, max_parts, max(OVERCUT * volume_error * volume - gained, least))
    hulls = [piece.hull for piece in pieces]
    return [hull_mesh(hull) for hull in merge_hulls(hulls, (1 + volume_error) * volume, max_parts)]


def union_of_parts(parts: list[trimesh.Trimesh]) -> Solid:
    """The union of convex parts.

    Raises:
        RejectedError: A part does not bound a solid.
    """
    together = union(to_solid(part.vertices, part.faces) for part in parts)
    if not is_solid(together):
        raise RejectedError("a convex part does not bound a solid")
    return together


def _solid(mesh: trimesh.Trimesh) -> Solid:
    """The simplified solid within a surface, wound outwards.

    Inside out, a surface bounds everything but the object, and every hull would be of that.
    """
    check_mesh(mesh)
    solid = to_solid(mesh.vertices, mesh.faces)
    if solid.volume() < 0:
        solid = to_solid(mesh.vertices, mesh.faces[:, ::-1])
    size = float(np.ptp(mesh.vertices, axis=0).max())
    if not is_solid(solid) or not solid.volume() > ROUNDING * size**3:
        raise RejectedError("the surface does not bound a solid")
    simple = solid.simplify(SIMPLIFICATION * size)
    # Anew, for it keeps its tolerance, and every cut would be simplified by as much again.
    exact = to_solid(*arrays(simple))
    return exact if is_solid(exact) and exact.volume() > 0 else solid


def _split(whole: Solid, max_parts: int, allowed: float) -> list[_Piece]:
    """Cut a solid until its pieces have at most the allowed excess, or there are enough."""
    crumb = SLIVER * whole.volume()
    bodies = _bodies(whole, crumb)
    if len(bodies) > max_parts:
        raise RejectedError(f"{len(bodies)} separate bodies, more than {max_parts} convex parts")
    numbers = count()
    heap = [_piece(body, numbers) for body in bodies]
    heapq.heapify(heap)
    for _ in range(SPARE * max_parts):
        if len(heap) >= SPARE * max_parts or -sum(p.negative_excess for p in heap) <= allowed:
            break
        halves = _best_cut(heapq.heappop(heap))
        for body in (body for half in halves for body in _bodies(half, crumb)):
            heapq.heappush(heap, _piece(body, numbers))
    return sorted(heap)


def _piece(solid: Solid, numbers: Iterator[int]) -> _Piece:
    hull, planes = hull_and_planes(arrays(solid)[0])
    return _Piece(solid.volume() - hull.volume, next(numbers), solid, hull, planes)


def _best_cut(piece: _Piece) -> tuple[Solid, Solid]:
    """The two sides of the plane whose sides lie closest to their hulls."""
    vertices, faces = arrays(piece.solid)
    edges = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    edges = edges[edges[:, 0] < edges[:, 1]]  # each once
    planes = _planes(vertices, faces, _depths(vertices, piece.planes))
    least = GRAZE * float(np.ptp(vertices, axis=0).max())
    sides = [_sides(vertices, edges, plane, least) for plane in planes]
    best = _smallest(sides)
    normal, offset = planes[best]
    cut: tuple[Solid, Solid] = piece.solid.split_by_plane(tuple(normal), offset)
    return cut


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


def _depths(points: Floats, planes: Floats) -> Floats:
    """How far points lie below the planes of their hull, (n,)."""
    depths: Floats = -(points @ planes[:, :3].T + planes[:, 3]).max(axis=1)
    return depths


def _bodies(solid: Solid, crumb: float) -> list[Solid]:
    return [body for body in solid.decompose() if body.volume() > crumb]

"""Convex parts of a solid, for physics engines that collide only convex bodies."""

import heapq
from collections.abc import Iterator
from itertools import count, product
from typing import NamedTuple

import numpy as np
import trimesh
from numpy.typing import NDArray

from egad.errors import RejectedError
from egad.shapes.manifold import Solid, arrays, is_solid, to_mesh, to_solid, union

Floats = NDArray[np.float64]
Plane = tuple[Floats, float]  # unit normal, distance from the origin

SIMPLIFICATION = 0.005  # of the longest side: finer detail costs time and changes no contact
SLIVER = 1e-6  # of the volume: thinner crumbs have no usable hull
EVEN_PLANES = 3  # a coordinate axis


class _Piece(NamedTuple):
    """A piece in the heap: the one whose hull adds most volume comes out first."""

    negative_excess: float
    number: int  # of equals, the older one
    solid: Solid


def _directions() -> Floats:
    """The axes and face diagonals of a cube, (9, 3)."""
    steps = [v for v in product((0, 1, -1), repeat=3) if sum(map(abs, v)) in (1, 2)]
    half = np.array([v for v in steps if v > (0, 0, 0)], dtype=np.float64)
    unit: Floats = half / np.linalg.norm(half, axis=1, keepdims=True)
    return unit


DIRECTIONS = _directions()


def convex_parts(
    mesh: trimesh.Trimesh, max_parts: int, volume_error: float
) -> list[trimesh.Trimesh]:
    """Convex hulls that together stand for a solid (ours).

    The solid is cut again and again: always the piece whose hull exceeds it by the largest
    volume, at the plane that leaves the least such excess. The planes tried go through the point
    that lies deepest below the hull, in nine directions, and in even steps along the axes. Cuts
    are exact, so nothing of the solid is lost but a simplification by at most 0.5 % of its
    longest side.

    Args:
        mesh: A closed surface, wound either way, in any unit.
        max_parts: Most hulls; reached only by objects that need more.
        volume_error: Cutting stops when the hulls exceed the solid by this fraction of it.

    Returns:
        Convex meshes with outward normals, at least one.

    Raises:
        RejectedError: The mesh does not bound a solid, or has more bodies than `max_parts`.
    """
    whole = _solid(mesh)
    pieces = _split(whole, max_parts, volume_error * whole.volume())
    return [to_mesh(piece.hull()) for piece in pieces]


def excess_volume(parts: list[trimesh.Trimesh], mesh: trimesh.Trimesh) -> float:
    """Volume of the union of the parts / volume of the mesh - 1."""
    together = union(to_solid(part.vertices, part.faces) for part in parts)
    return float(together.volume() / abs(mesh.volume) - 1)


def _solid(mesh: trimesh.Trimesh) -> Solid:
    """The simplified solid within a surface, wound outwards.

    Inside out, a surface bounds everything but the object, and every hull would be of that.
    """
    if len(mesh.faces) == 0 or not np.isfinite(mesh.vertices).all():
        raise RejectedError("no faces, or coordinates that are not finite")
    solid = to_solid(mesh.vertices, mesh.faces)
    if solid.volume() < 0:
        solid = to_solid(mesh.vertices, mesh.faces[:, ::-1])
    if not is_solid(solid) or not solid.volume() > 0:
        raise RejectedError("the surface does not bound a solid")
    return solid.simplify(SIMPLIFICATION * float(np.ptp(mesh.vertices, axis=0).max()))


def _split(whole: Solid, max_parts: int, allowed: float) -> list[Solid]:
    """Cut a solid until its pieces have at most the allowed excess, or are the most allowed."""
    crumb = SLIVER * whole.volume()
    bodies = _bodies(whole, crumb)
    if len(bodies) > max_parts:
        raise RejectedError(f"{len(bodies)} separate bodies, more than {max_parts} convex parts")
    numbers = count()
    heap = [_piece(body, numbers) for body in bodies]
    heapq.heapify(heap)
    for _ in range(max_parts - len(heap)):  # each cut adds a piece at least, or cuts off a crumb
        if len(heap) >= max_parts or -sum(piece.negative_excess for piece in heap) <= allowed:
            break
        halves = _best_cut(heapq.heappop(heap).solid)
        bodies = [body for half in halves for body in _bodies(half, crumb)]
        fits = len(heap) + len(bodies) <= max_parts
        for solid in bodies if fits else halves:
            heapq.heappush(heap, _piece(solid, numbers))
    return [piece.solid for piece in sorted(heap)]


def _piece(solid: Solid, numbers: Iterator[int]) -> _Piece:
    return _Piece(solid.volume() - solid.hull().volume(), next(numbers), solid)


def _best_cut(solid: Solid) -> tuple[Solid, Solid]:
    """The two sides of the plane whose sides lie closest to their hulls."""
    cuts = [solid.split_by_plane(tuple(normal), offset) for normal, offset in _planes(solid)]
    cuts = [cut for cut in cuts if not cut[0].is_empty() and not cut[1].is_empty()]
    excesses = [_excess(first) + _excess(second) for first, second in cuts]
    best: tuple[Solid, Solid] = cuts[int(np.argmin(excesses))]
    return best


def _planes(solid: Solid) -> list[Plane]:
    vertices, _ = arrays(solid)
    deepest = vertices[_depths(solid, vertices).argmax()]
    through = [(normal, float(normal @ deepest)) for normal in DIRECTIONS]
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    steps = np.arange(1, EVEN_PLANES + 1) / (EVEN_PLANES + 1)
    even = [
        (normal, float(low[axis] + step * (high[axis] - low[axis])))
        for axis, normal in enumerate(np.eye(3))
        for step in steps
    ]
    return through + even


def _depths(solid: Solid, points: Floats) -> Floats:
    """How far points lie below the hull of a solid, (n,)."""
    hull = to_mesh(solid.hull())
    normals, wide = trimesh.triangles.normals(hull.triangles)  # needles have none
    offsets = np.einsum("ij,ij->i", normals, hull.triangles[wide, 0])
    depths: Floats = (offsets - points @ normals.T).min(axis=1)
    return depths


def _bodies(solid: Solid, crumb: float) -> list[Solid]:
    return [body for body in solid.decompose() if body.volume() > crumb]


def _excess(solid: Solid) -> float:
    return float(solid.hull().volume() - solid.volume())

"""Convex parts of a solid, for physics engines that collide only convex bodies."""

import heapq
from collections.abc import Iterator
from itertools import count
from typing import NamedTuple

import numpy as np
import trimesh
from numpy.typing import NDArray

from egad._util.workers import one_thread
from egad.errors import RejectedError
from egad.geometry.checks import ROUNDING, check_mesh
from egad.geometry.cuts import best_plane, middle_plane
from egad.geometry.fit import Tolerances, finish, fits, too_deep
from egad.geometry.hulls import Hull, hull_and_planes, hull_mesh, merge_hulls
from egad.geometry.manifold import Solid, arrays, is_solid, to_mesh, to_solid, union
from egad.geometry.parameters import DEVIATION, MAX_VERTICES
from egad.geometry.touchable import Touchable, touchable_points

Floats = NDArray[np.float64]

# The surface is simplified by this part of the allowed deviation, but by no more than that part of
# the longest side: finer detail costs time and changes no contact.
SIMPLIFICATION, LARGEST_SIMPLIFICATION = 0.3, 0.005
SLIVER = 1e-6  # of the volume: thinner crumbs have no usable hull
# Cutting goes on to this part of the allowed error; then parts are joined again until it is spent.
OVERCUT = 0.7
LEAST_EXCESS = 0.3  # of the allowed error, for solids that simplification made larger
BURIED = 0.002  # of the touchable points: may stay too deep in the hulls of pieces
CONVEX = 1e-3  # of a hull: with less excess a solid has no hollow to cut at
SPARE = 2  # times as many pieces as parts are allowed are cut at most


class _Piece(NamedTuple):
    """A piece in the heap: the one farthest beyond its bounds comes out first."""

    negative_badness: float
    number: int  # of equals, the older one
    solid: Solid
    hull: Hull
    planes: Floats  # of the hull, (n, 4): outward normals and offsets
    touchable: Touchable  # on its side of all cuts, so that no other hull holds them
    excess: float  # volume of the hull beyond the solid
    buried: int  # touchable points that lie too deep in the hull
    has_too_many_vertices: bool


class _Limits(NamedTuple):
    """How far all pieces together may be from the solid."""

    pieces: int
    excess: float  # volume
    buried: float  # touchable points
    tolerances: Tolerances


def convex_parts(
    mesh: trimesh.Trimesh,
    max_parts: int,
    volume_error: float,
    deviation: float = DEVIATION,
    max_vertices: int = MAX_VERTICES,
) -> list[trimesh.Trimesh]:
    """Convex hulls that together stand for a solid (ours).

    The solid is cut again and again: always the piece whose hull is worst, at the plane that leaves
    the smallest hulls. A hull is bad if it exceeds the solid, if points that a finger can touch lie
    deep in it, or if it needs too many vertices. Then pieces whose common hull adds least are
    joined again, as long as it stays within the bounds; this undoes unlucky cuts. In the end faces
    of hulls that bridge a hollow are moved inwards, so that they lie in the middle of the hollow,
    and corners that matter little are left out.

    Points that fingers can touch lie deeper in a part than `deviation` at about 1 % of the surface,
    and the parts leave out a layer about as thick at most.

    Args:
        mesh: A closed surface, wound either way, metres.
        max_parts: Most hulls; reached only by objects that need more. Then the bounds are not kept.
        volume_error: The hulls may exceed the solid by this fraction of it.
        deviation: How deep the touchable surface may lie in a hull, metres.
        max_vertices: Of a hull.

    Returns:
        Convex meshes with outward normals, at least one.

    Raises:
        RejectedError: The mesh does not bound a solid, or has more bodies than `max_parts`.
        UserError: It is not a mesh.
    """
    with one_thread():  # several take twice the CPU time for matrices as small as these
        return _convex_parts(_solid(mesh), max_parts, volume_error, deviation, max_vertices)


def _convex_parts(
    exact: Solid, max_parts: int, volume_error: float, deviation: float, max_vertices: int
) -> list[trimesh.Trimesh]:
    whole = _simplified(exact, deviation)
    volume = exact.volume()
    gained = whole.volume() - volume
    least = LEAST_EXCESS * volume_error * volume
    touchable = touchable_points(to_mesh(exact), "parts")
    tolerances = Tolerances(deviation, volume_error, max_vertices)
    limits = _Limits(
        SPARE * max_parts,
        max(OVERCUT * volume_error * volume - gained, least),
        BURIED * len(touchable.points),
        tolerances,
    )
    bodies = _bodies(whole, SLIVER * volume)
    if len(bodies) > max_parts:
        raise RejectedError(f"{len(bodies)} separate bodies, more than {max_parts} convex parts")
    hulls = [piece.hull for piece in _split(bodies, touchable, limits)]
    joined = merge_hulls(
        hulls, (1 + volume_error) * volume, max_parts, lambda h: fits(h, touchable, tolerances)
    )
    return [hull_mesh(finish(hull, touchable, tolerances)) for hull in joined]


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
    """The solid within a surface, wound outwards.

    Inside out, a surface bounds everything but the object, and every hull would be of that.
    """
    check_mesh(mesh)
    solid = to_solid(mesh.vertices, mesh.faces)
    if solid.volume() < 0:
        solid = to_solid(mesh.vertices, mesh.faces[:, ::-1])
    size = float(np.ptp(mesh.vertices, axis=0).max())
    if not is_solid(solid) or not solid.volume() > ROUNDING * size**3:
        raise RejectedError("the surface does not bound a solid")
    return solid


def _simplified(solid: Solid, deviation: float) -> Solid:
    low, high = np.reshape(solid.bounding_box(), (2, 3))
    by = min(SIMPLIFICATION * deviation, LARGEST_SIMPLIFICATION * float((high - low).max()))
    # Anew, for it keeps its tolerance, and every cut would be simplified by as much again.
    simple = to_solid(*arrays(solid.simplify(by)))
    return simple if is_solid(simple) and simple.volume() > 0 else solid


def _split(bodies: list[Solid], touchable: Touchable, limits: _Limits) -> list[_Piece]:
    """Cut solids until their pieces are within the limits, or there are enough."""
    crumb = SLIVER * sum(body.volume() for body in bodies)
    numbers = count()
    heap = [_piece(body, touchable, numbers, limits) for body in bodies]
    heapq.heapify(heap)
    for _ in range(limits.pieces):
        if len(heap) >= limits.pieces or _are_good(heap, limits):
            break
        piece = heapq.heappop(heap)
        hollow = piece.buried or piece.excess > CONVEX * piece.hull.volume
        plane = best_plane(piece.solid, piece.planes) if hollow else middle_plane(piece.solid)
        normal, offset = plane
        halves = piece.solid.split_by_plane(tuple(normal), offset)
        above = piece.touchable.points @ normal > offset
        for half, side in zip(halves, (above, ~above), strict=True):
            points = piece.touchable.where(side)
            for body in _bodies(half, crumb):
                heapq.heappush(heap, _piece(body, points, numbers, limits))
    return sorted(heap)


def _piece(solid: Solid, touchable: Touchable, numbers: Iterator[int], limits: _Limits) -> _Piece:
    hull, planes = hull_and_planes(arrays(solid)[0])
    excess = hull.volume - solid.volume()
    buried = int(too_deep(touchable, hull, planes, limits.tolerances).sum())
    too_many = not limits.tolerances.can_be_reduced(hull)
    badness = excess / limits.excess + buried / max(limits.buried, 1) + too_many
    return _Piece(-badness, next(numbers), solid, hull, planes, touchable, excess, buried, too_many)


def _are_good(pieces: list[_Piece], limits: _Limits) -> bool:
    return (
        not any(piece.has_too_many_vertices for piece in pieces)
        and sum(piece.excess for piece in pieces) <= limits.excess
        and sum(piece.buried for piece in pieces) <= limits.buried
    )


def _bodies(solid: Solid, crumb: float) -> list[Solid]:
    return [body for body in solid.decompose() if body.volume() > crumb]

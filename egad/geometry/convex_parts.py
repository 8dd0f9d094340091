"""Convex parts of a solid, for physics engines that collide only convex bodies."""

import heapq
from collections.abc import Iterable, Iterator
from functools import partial
from itertools import count
from typing import NamedTuple

import numpy as np
import trimesh

from egad._util.arrays import dot_products
from egad._util.child_process import one_thread
from egad.errors import RejectedError
from egad.geometry.checks import check_mesh
from egad.geometry.cuts import best_plane, middle_plane
from egad.geometry.fit import LOWERING, STEP, Tolerances, finish_all, fits, too_deep
from egad.geometry.hulls import Hull, hull_mesh, hull_of, merge_hulls
from egad.geometry.manifold import Solid, arrays, is_solid, solid_within, to_mesh, to_solid, union
from egad.geometry.parameters import DEVIATION, MAX_VERTICES
from egad.geometry.touchable import MAX_BURIED, Touchable, touchable_points

# The surface is simplified by the first fraction of the allowed deviation, but by no more than the
# second fraction of the longest side: finer detail costs time and changes no contact.
SIMPLIFICATION, MAX_SIMPLIFICATION = 0.3, 0.005
SLIVER = 1e-6  # of the volume: smaller crumbs have no usable hull
# Cutting stops at this fraction of the allowed error; then parts are merged until it is used up.
OVERCUT = 0.7
MIN_EXCESS = 0.3  # of the allowed error: the minimum, for solids that simplification made larger
BURIED = 0.002  # of the touchable points may stay too deep in the hulls of pieces
CONVEX = 1e-3  # of a hull: with less excess a solid has no hollow to cut at
SPARE = 2  # at most this many times as many pieces are cut as parts are allowed


class Decomposition(NamedTuple):
    """Convex parts, and the error bounds that they meet."""

    parts: list[trimesh.Trimesh]  # convex meshes with outward normals, at least one
    deviation: float  # how deep the touchable surface lies in a part, metres
    volume_error: float  # by how much the parts exceed the solid, as a fraction of it


class _Piece(NamedTuple):
    """A piece in the heap: the one that exceeds its bounds most is popped first."""

    negative_badness: float
    number: int  # breaks ties: the older piece first
    solid: Solid
    hull: Hull
    touchable: Touchable  # points on its side of all cuts, so that no other hull holds them
    excess: float  # volume of the hull beyond the solid
    buried: int  # touchable points that lie too deep in the hull


class _Limits(NamedTuple):
    """How far all pieces together may be from the solid."""

    pieces: int
    excess: float  # volume
    buried: float  # touchable points
    tolerances: Tolerances


def decompose(
    mesh: trimesh.Trimesh,
    max_parts: int,
    volume_error: float,
    deviation: float = DEVIATION,
    max_vertices: int = MAX_VERTICES,
) -> Decomposition:
    """Convex hulls that together approximate a solid (ours), and the bounds that they meet.

    The piece with the worst hull is cut along the plane that leaves the smallest hulls, until none
    exceeds the solid, lies over points that a finger can touch, or has too many vertices. Then the
    pieces whose common hull adds least are merged within the bounds, which are loosened if there
    are still too many; faces over hollows move to their middle. About 1 % of the touchable surface
    may lie deeper than `deviation`, metres. `RejectedError` if it is no solid, or has more bodies
    than `max_parts`.
    """
    with one_thread():  # several threads take twice the CPU time for such small matrices
        tolerances = Tolerances(deviation, volume_error, max_vertices, LOWERING * deviation)
        check_mesh(mesh)
        solid = solid_within(mesh)
        if solid.volume() <= 0:  # inside out, it would bound all but the object
            solid = to_solid(mesh.vertices, mesh.faces[:, ::-1])
        return _decomposed(solid, max_parts, tolerances)


def _decomposed(exact: Solid, max_parts: int, wanted: Tolerances) -> Decomposition:
    whole, volume = _simplified(exact, wanted.deviation), exact.volume()
    allowed = wanted.volume_error * volume
    touchable = touchable_points(to_mesh(exact), "parts")
    limits = _Limits(
        SPARE * max_parts,
        max(OVERCUT * allowed - (whole.volume() - volume), MIN_EXCESS * allowed),
        BURIED * len(touchable.points),
        wanted,
    )
    bodies = _bodies(whole, SLIVER * volume)
    if len(bodies) > max_parts:
        raise RejectedError(f"{len(bodies)} separate bodies, more than {max_parts} convex parts")
    pieces, are_good = _split(bodies, touchable, limits)
    hulls = [piece.hull for piece in pieces]
    hulls, kept = _joined(hulls, are_good, max_parts, volume, touchable, wanted)
    finished, kept = finish_all(hulls, to_mesh(exact), touchable, kept, wanted)
    return Decomposition([*map(hull_mesh, finished)], kept.deviation, kept.volume_error)


def _joined(
    hulls: list[Hull],
    are_good: bool,
    max_parts: int,
    volume: float,
    touchable: Touchable,
    wanted: Tolerances,
) -> tuple[list[Hull], Tolerances]:
    """Merge hulls of pieces of a solid, with looser bounds until few enough are left; and these."""
    kept = wanted
    for power in count():
        kept = wanted.loosened(STEP**power)
        allowed = (1 + kept.volume_error) * volume
        hulls = merge_hulls(hulls, allowed, partial(fits, touchable=touchable, tolerances=kept))
        if len(hulls) <= max_parts and (are_good or _keep(hulls, allowed, touchable, kept)):
            break
    return hulls, kept


def _keep(hulls: list[Hull], volume: float, touchable: Touchable, tolerances: Tolerances) -> bool:
    """Whether hulls meet the bounds together."""
    buried = sum(int(too_deep(touchable, hull, tolerances).sum()) for hull in hulls)
    return (
        sum(hull.volume for hull in hulls) <= volume
        and buried <= MAX_BURIED * len(touchable.points)
        and all(map(tolerances.can_be_reduced, hulls))
    )


def union_of_parts(parts: Iterable[trimesh.Trimesh]) -> Solid:
    """The union of convex parts; `RejectedError` if one does not bound a solid."""
    together = union(to_solid(part.vertices, part.faces) for part in parts)
    if not is_solid(together):
        raise RejectedError("a convex part does not bound a solid")
    return together


def _simplified(solid: Solid, deviation: float) -> Solid:
    low, high = np.reshape(solid.bounding_box(), (2, 3))
    by = min(SIMPLIFICATION * deviation, MAX_SIMPLIFICATION * float((high - low).max()))
    # Made anew: a solid keeps its tolerance, and every cut would be simplified by as much again.
    simple = to_solid(*arrays(solid.simplify(by)))
    return simple if is_solid(simple) and simple.volume() > 0 else solid


def _split(bodies: list[Solid], touchable: Touchable, limits: _Limits) -> tuple[list[_Piece], bool]:
    """Pieces of solids that are within the limits, or enough; and whether they are within them."""
    crumb = SLIVER * sum(body.volume() for body in bodies)
    numbers = count()
    heap = [_piece(body, touchable, numbers, limits) for body in bodies]
    heapq.heapify(heap)
    few_corners: set[int] = set()
    for _ in range(limits.pieces):
        if len(heap) >= limits.pieces:
            break
        piece = _worst(heap, limits, few_corners)
        if piece is None:
            return sorted(heap), True
        hollow = piece.buried or piece.excess > CONVEX * piece.hull.volume
        plane = best_plane(piece.solid, piece.hull.planes) if hollow else middle_plane(piece.solid)
        normal, offset = plane
        halves = piece.solid.split_by_plane(tuple(normal), offset)
        above = dot_products(piece.touchable.points, normal[None])[:, 0] > offset
        for half, side in zip(halves, (above, ~above), strict=True):
            points = piece.touchable.where(side)
            for body in _bodies(half, crumb):
                heapq.heappush(heap, _piece(body, points, numbers, limits))
    return sorted(heap), False


def _piece(solid: Solid, touchable: Touchable, numbers: Iterator[int], limits: _Limits) -> _Piece:
    hull = hull_of(arrays(solid)[0])
    excess = hull.volume - solid.volume()
    buried = int(too_deep(touchable, hull, limits.tolerances).sum())
    badness = excess / limits.excess + buried / max(limits.buried, 1)
    return _Piece(-badness, next(numbers), solid, hull, touchable, excess, buried)


def _worst(heap: list[_Piece], limits: _Limits, few_corners: set[int]) -> _Piece | None:
    """Pop the piece to cut next from the heap; None if all are within the limits."""
    if (
        sum(piece.excess for piece in heap) > limits.excess
        or sum(piece.buried for piece in heap) > limits.buried
    ):
        return heapq.heappop(heap)
    for piece in sorted(heap):
        if piece.number in few_corners or limits.tolerances.can_be_reduced(piece.hull):
            few_corners.add(piece.number)
            continue
        heap.remove(piece)
        heapq.heapify(heap)
        return piece
    return None


def _bodies(solid: Solid, crumb: float) -> list[Solid]:
    return [body for body in solid.decompose() if body.volume() > crumb]

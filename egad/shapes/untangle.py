"""Removing places where the surface of a solid passes through itself."""

import numpy as np
from numpy.typing import NDArray

from egad.errors import RejectedError
from egad.shapes.crossings import crossings
from egad.shapes.manifold import Solid, arrays, box, is_solid, union

Floats = NDArray[np.float64]

DEPTH = 1e-6  # of the longest side: shallower crossings are rounding
MARGIN = 1e-3  # of the longest side: left around the triangles that cross
CRUMB = 0.05  # of the longest side: smaller pieces that still cross become their hull
ROUNDS = 4


def untangle(solid: Solid) -> Solid:
    """A solid whose surface does not pass through itself (ours).

    The smallest boxes around the triangles that cross are cut out. Within them the solid falls
    into bodies that overlap: their union has one surface. A piece that crosses itself is halved
    until its parts do not, or are crumbs, which are replaced by their convex hull. What is inside
    out is dropped. Then the pieces are put back, and all else stays as it was.

    Raises:
        RejectedError: The surface still passes through itself after some rounds.
    """
    for _ in range(ROUNDS):
        vertices, faces = arrays(solid)
        size = float(np.ptp(vertices, axis=0).max())
        crossing = crossings(vertices, faces, DEPTH * size)
        if len(crossing) == 0:
            return solid
        corners = vertices[faces[np.unique(crossing)]]
        lows, highs = _merged(
            corners.min(axis=1) - MARGIN * size, corners.max(axis=1) + MARGIN * size
        )
        inside, outside = solid.split(union(map(box, lows, highs)))
        solid = union([outside, *_apart(inside, size)])
    raise RejectedError("the surface passes through itself, and could not be untangled")


def _apart(piece: Solid, size: float) -> list[Solid]:
    """Bodies without crossings that together fill a piece."""
    return [part for body in piece.decompose() for part in _halved(body, size)]


def _halved(body: Solid, size: float) -> list[Solid]:
    if not is_solid(body) or body.volume() <= 0:
        return []
    vertices, faces = arrays(body)
    if len(crossings(vertices, faces, DEPTH * size)) == 0:
        return [body]
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    axis = int(np.argmax(high - low))
    if high[axis] - low[axis] < CRUMB * size:
        return [body.hull()]
    middle = float(low[axis] + high[axis]) / 2
    halves = body.split_by_plane(tuple(np.eye(3)[axis]), middle)
    return [part for half in halves for part in _apart(half, size)]


def _merged(low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """The common boxes of boxes that overlap, so that no two of the result do."""
    lows, highs = low[:0], high[:0]
    for new in zip(low, high, strict=True):
        first, last = new
        while (touching := _overlap(lows, highs, first, last)).any():
            first = np.minimum(first, lows[touching].min(axis=0))
            last = np.maximum(last, highs[touching].max(axis=0))
            lows, highs = lows[~touching], highs[~touching]
        lows, highs = np.vstack([lows, first]), np.vstack([highs, last])
    return lows, highs


def _overlap(lows: Floats, highs: Floats, low: Floats, high: Floats) -> NDArray[np.bool_]:
    overlap: NDArray[np.bool_] = np.all((lows <= high) & (low <= highs), axis=1)
    return overlap

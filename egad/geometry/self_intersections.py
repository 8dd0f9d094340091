"""Find where a surface passes through itself, and remove these regions."""

import numpy as np

from egad._util.arrays import Floats, Ints
from egad._util.kernels import kernel
from egad.errors import RejectedError
from egad.geometry.manifold import Solid, arrays, box, is_solid, union

DEPTH = 1e-6  # of the longest side: shallower crossings are rounding
MARGIN = 1e-3  # of the longest side: left around the triangles that cross
CRUMB = 0.05  # of the longest side: smaller pieces that still cross are replaced by their hull
ROUNDS = 4


def crossings(vertices: Floats, faces: Ints, depth: float) -> Ints:
    """Pairs (k, 2) of triangles: an edge of one pierces the other, ending beyond `depth` (ours)."""
    if len(faces) == 0:
        return np.empty((0, 2), dtype=np.int64)
    axis = int(np.argmax(np.ptp(vertices, axis=0)))
    turned = np.ascontiguousarray(np.roll(vertices, -axis, axis=1), dtype=np.float64)
    corners = turned[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    pairs: Ints = _sweep(
        turned,
        np.ascontiguousarray(faces, dtype=np.int64),
        np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0),
        np.ascontiguousarray(corners.min(axis=1)),
        np.ascontiguousarray(corners.max(axis=1)),
        depth,
    )
    return pairs


@kernel()
def _sweep(
    vertices: Floats, faces: Ints, normals: Floats, low: Floats, high: Floats, depth: float
) -> Ints:
    """Test the pairs whose boxes overlap, found along the first coordinate."""
    order = np.argsort(low[:, 0], kind="mergesort")
    low, high = low[order], high[order]
    found = []
    for first in range(len(order)):
        for second in range(first + 1, len(order)):
            if low[second, 0] > high[first, 0]:
                break
            if low[first, 1] > high[second, 1] or low[second, 1] > high[first, 1]:
                continue
            if low[first, 2] > high[second, 2] or low[second, 2] > high[first, 2]:
                continue
            i, j = order[first], order[second]
            if _pierces(vertices, faces, normals, i, j, depth) or _pierces(
                vertices, faces, normals, j, i, depth
            ):
                found.append((i, j))
    pairs = np.empty((len(found), 2), dtype=np.int64)
    for row, (i, j) in enumerate(found):
        pairs[row, 0], pairs[row, 1] = i, j
    return pairs


@kernel()
def _pierces(
    vertices: Floats, faces: Ints, normals: Floats, first: int, second: int, depth: float
) -> bool:
    """Whether an edge of the first triangle passes through the second."""
    for k in range(3):
        p, q = faces[first, k], faces[first, (k + 1) % 3]
        if _is_corner(p, faces, second) or _is_corner(q, faces, second):
            continue
        above = _height(vertices, p, faces, normals, second)
        below = _height(vertices, q, faces, normals, second)
        if above * below >= 0.0 or min(abs(above), abs(below)) <= depth:
            continue
        if _passes_within(vertices, p, q, faces, second):
            return True
    return False


@kernel()
def _is_corner(vertex: int, faces: Ints, face: int) -> bool:
    a, b, c = faces[face, 0], faces[face, 1], faces[face, 2]
    return bool(vertex in (a, b, c))


@kernel()
def _height(vertices: Floats, vertex: int, faces: Ints, normals: Floats, face: int) -> float:
    """Signed distance of a vertex from the plane of a triangle; 0 if that has no area."""
    height = 0.0
    for k in range(3):
        height += normals[face, k] * (vertices[vertex, k] - vertices[faces[face, 0], k])
    return height


@kernel()
def _passes_within(vertices: Floats, p: int, q: int, faces: Ints, face: int) -> bool:
    """Whether the line p-q winds the same way about all three sides of a triangle."""
    a, b, c = faces[face, 0], faces[face, 1], faces[face, 2]
    x = _turn(vertices, p, q, a, b)
    y = _turn(vertices, p, q, b, c)
    z = _turn(vertices, p, q, c, a)
    return bool((x >= 0 and y >= 0 and z >= 0) or (x <= 0 and y <= 0 and z <= 0))


@kernel()
def _turn(vertices: Floats, p: int, q: int, a: int, b: int) -> float:
    """Six times the signed volume of the tetrahedron p, q, a, b."""
    total = 0.0
    for k in range(3):
        m, n = (k + 1) % 3, (k + 2) % 3
        cross = (vertices[a, m] - vertices[p, m]) * (vertices[b, n] - vertices[p, n])
        cross -= (vertices[a, n] - vertices[p, n]) * (vertices[b, m] - vertices[p, m])
        total += (vertices[q, k] - vertices[p, k]) * cross
    return total


def untangle(solid: Solid) -> Solid:
    """A solid whose surface does not pass through itself (ours), or `RejectedError`.

    Boxes around crossings are cut out and rebuilt as unions; what crosses itself is halved.
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
    raise RejectedError("the surface intersects itself and could not be repaired")


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
    """Merge boxes that overlap, until no two of them do."""
    lows, highs = low[:0], high[:0]
    for new in zip(low, high, strict=True):
        first, last = new
        while (touching := ((lows <= last) & (first <= highs)).all(axis=1)).any():
            first = np.minimum(first, lows[touching].min(axis=0))
            last = np.maximum(last, highs[touching].max(axis=0))
            lows, highs = lows[~touching], highs[~touching]
        lows, highs = np.vstack([lows, first]), np.vstack([highs, last])
    return lows, highs

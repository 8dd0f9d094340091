"""Where a surface passes through itself."""

import numba
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def crossings(vertices: Floats, faces: Ints, depth: float) -> Ints:
    """Pairs of triangles of which one pierces the other (ours: sweep, then exact signs).

    An edge pierces a triangle when its ends lie more than `depth` off the triangle's plane, on
    either side, and it passes within the triangle's border. Triangles that lie in one plane do
    not pierce each other. A vertex that both triangles share is no crossing.

    Args:
        vertices: (n, 3).
        faces: (m, 3) vertex indices.
        depth: Crossings that are shallower are noise; same unit as the vertices.

    Returns:
        (k, 2) indices of faces.
    """
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


@numba.njit(cache=True)
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


@numba.njit(cache=True)
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


@numba.njit(cache=True)
def _is_corner(vertex: int, faces: Ints, face: int) -> bool:
    a, b, c = faces[face, 0], faces[face, 1], faces[face, 2]
    return bool(vertex in (a, b, c))


@numba.njit(cache=True)
def _height(vertices: Floats, vertex: int, faces: Ints, normals: Floats, face: int) -> float:
    """Signed distance of a vertex from the plane of a triangle; 0 if that has no area."""
    height = 0.0
    for k in range(3):
        height += normals[face, k] * (vertices[vertex, k] - vertices[faces[face, 0], k])
    return height


@numba.njit(cache=True)
def _passes_within(vertices: Floats, p: int, q: int, faces: Ints, face: int) -> bool:
    """Whether the line p-q winds the same way about all three sides of a triangle."""
    a, b, c = faces[face, 0], faces[face, 1], faces[face, 2]
    x = _turn(vertices, p, q, a, b)
    y = _turn(vertices, p, q, b, c)
    z = _turn(vertices, p, q, c, a)
    return bool((x >= 0 and y >= 0 and z >= 0) or (x <= 0 and y <= 0 and z <= 0))


@numba.njit(cache=True)
def _turn(vertices: Floats, p: int, q: int, a: int, b: int) -> float:
    """Six times the signed volume of the tetrahedron p, q, a, b."""
    total = 0.0
    for k in range(3):
        m, n = (k + 1) % 3, (k + 2) % 3
        cross = (vertices[a, m] - vertices[p, m]) * (vertices[b, n] - vertices[p, n])
        cross -= (vertices[a, n] - vertices[p, n]) * (vertices[b, m] - vertices[p, m])
        total += (vertices[q, k] - vertices[p, k]) * cross
    return total

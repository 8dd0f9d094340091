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
    pairs: Ints = _sweep(
        turned,
        np.ascontiguousarray(faces, dtype=np.int64),
        np.ascontiguousarray(corners.min(axis=1)),
        np.ascontiguousarray(corners.max(axis=1)),
        depth,
    )
    return pairs


@numba.njit(cache=True)
def _sweep(vertices: Floats, faces: Ints, low: Floats, high: Floats, depth: float) -> Ints:
    """Test the pairs whose boxes overlap, found along the first coordinate."""
    order = np.argsort(low[:, 0], kind="mergesort")
    found = []
    for start in range(len(order)):
        i = order[start]
        for later in range(start + 1, len(order)):
            j = order[later]
            if low[j, 0] > high[i, 0]:
                break
            if not _boxes_overlap(low[i], high[i], low[j], high[j]):
                continue
            if _pierces(vertices, faces[i], faces[j], depth) or _pierces(
                vertices, faces[j], faces[i], depth
            ):
                found.append((i, j))
    pairs = np.empty((len(found), 2), dtype=np.int64)
    for row, (i, j) in enumerate(found):
        pairs[row, 0], pairs[row, 1] = i, j
    return pairs


@numba.njit(cache=True)
def _boxes_overlap(low_a: Floats, high_a: Floats, low_b: Floats, high_b: Floats) -> bool:
    beside = low_a[1] > high_b[1] or low_b[1] > high_a[1]
    return bool(not beside and low_a[2] <= high_b[2] and low_b[2] <= high_a[2])


@numba.njit(cache=True)
def _pierces(vertices: Floats, edges_of: Ints, triangle: Ints, depth: float) -> bool:
    """Whether an edge of one triangle passes through the other."""
    a, b, c = vertices[triangle[0]], vertices[triangle[1]], vertices[triangle[2]]
    normal = np.cross(b - a, c - a)
    length = np.sqrt((normal * normal).sum())
    if length == 0.0:
        return False
    for k in range(3):
        first, second = edges_of[k], edges_of[(k + 1) % 3]
        if _touches(first, triangle) or _touches(second, triangle):
            continue
        p, q = vertices[first], vertices[second]
        above = (normal * (p - a)).sum() / length
        below = (normal * (q - a)).sum() / length
        if above * below >= 0.0 or min(abs(above), abs(below)) <= depth:
            continue
        if _passes_within(p, q, a, b, c):
            return True
    return False


@numba.njit(cache=True)
def _touches(vertex: int, triangle: Ints) -> bool:
    return bool(vertex == triangle[0] or vertex == triangle[1] or vertex == triangle[2])


@numba.njit(cache=True)
def _passes_within(p: Floats, q: Floats, a: Floats, b: Floats, c: Floats) -> bool:
    """Whether the line p-q winds the same way about all three sides."""
    line = q - p
    x = (line * np.cross(a - p, b - p)).sum()
    y = (line * np.cross(b - p, c - p)).sum()
    z = (line * np.cross(c - p, a - p)).sum()
    return bool((x >= 0 and y >= 0 and z >= 0) or (x <= 0 and y <= 0 and z <= 0))

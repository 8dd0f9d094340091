"""A surface cut into ranges of a function on it: the nodes of the finest Reeb graph."""

from typing import NamedTuple

import numpy as np

from egad._util.arrays import Floats, Ints32
from egad._util.kernels import kernel
from egad.errors import RejectedError
from egad.geometry import Triangulation, lexicographic

_SPECK = 1e-6  # of the volume of a body: smaller shells inside it are cavities, however wound


class Parts(NamedTuple):
    """Connected parts of a surface within one range each, and which of them touch."""

    ranges: Ints32  # (n,)
    areas: Floats  # (n,)
    lengths: Floats  # (n,): how much of its range a part spans, in ranges
    links: Ints32  # (l, 2): a part and one in the next higher range, sorted


class _Crossings(NamedTuple):
    low: Ints32  # (e,): lowest range that an edge passes through
    high: Ints32  # (e,): highest one
    first: Ints32  # (e + 1,): number of the crossing of an edge with its lowest range


@kernel()
def cut(mesh: Triangulation, areas: Floats, values: Floats) -> Parts:
    """Cut a surface where a function (n,) of at least 0, linear on faces, takes integer values."""
    crossings = _crossings(mesh, values)
    roots = np.arange(crossings.first[-1]).astype(np.int32)
    _join_at_vertices(mesh, values, crossings, roots)
    carriers = np.empty(len(mesh.faces), np.int32)
    for face in range(len(mesh.faces)):
        carriers[face] = _join_face(mesh.face_edges[face], crossings, roots)
    part, count = labels(roots)
    ranges, sizes = np.empty(count, np.int32), np.zeros(count)
    lowest, highest = np.full(count, np.inf), np.zeros(count)
    for face in range(len(mesh.faces)):
        carrier, below = carriers[face], 0.0
        a, b, c = _ascending(values, mesh.faces[face])
        for step in range(crossings.low[carrier], crossings.high[carrier] + 1):
            i = part[crossings.first[carrier] + step - crossings.low[carrier]]
            fraction = _fraction(step + 1, a, b, c)
            ranges[i] = step
            sizes[i] += areas[face] * (fraction - below)
            lowest[i], highest[i] = min(lowest[i], max(a, step)), max(highest[i], min(c, step + 1))
            below = fraction
    return Parts(ranges, sizes, highest - lowest, _links(crossings, part, count))


@kernel()
def _crossings(mesh: Triangulation, values: Floats) -> _Crossings:
    count = len(mesh.edges)
    low, high = np.empty(count, np.int32), np.empty(count, np.int32)
    first = np.zeros(count + 1, np.int32)
    for edge in range(count):
        one, other = int(values[mesh.edges[edge, 0]]), int(values[mesh.edges[edge, 1]])
        low[edge], high[edge] = min(one, other), max(one, other)
        first[edge + 1] = first[edge] + high[edge] - low[edge] + 1
    return _Crossings(low, high, first)


@kernel()
def _join_at_vertices(
    mesh: Triangulation, values: Floats, crossings: _Crossings, roots: Ints32
) -> None:
    """Join the crossings that meet at a vertex, so that parts that touch only there are one."""
    met = np.full(len(values), -1, np.int32)
    for edge in range(len(mesh.edges)):
        for vertex in mesh.edges[edge]:
            crossing = crossings.first[edge] + int(values[vertex]) - crossings.low[edge]
            if met[vertex] < 0:
                met[vertex] = crossing
            else:
                unite(roots, met[vertex], crossing)


@kernel()
def _join_face(edges: Ints32, crossings: _Crossings, roots: Ints32) -> int:
    """Join the crossings of a face in each range; returns its edge that passes through them all."""
    low, high, first = crossings
    carrier: int = edges[0]
    for edge in edges[1:]:
        if high[edge] - low[edge] > high[carrier] - low[carrier]:
            carrier = edge
    for edge in edges:
        for step in range(low[edge], high[edge] + 1):
            one = first[carrier] + step - low[carrier]
            unite(roots, one, first[edge] + step - low[edge])
    return carrier


@kernel()
def unite(roots: Ints32, one: int, other: int) -> None:
    """Join two sets of a forest in which every item points towards the lowest of its set."""
    one, other = _root(roots, one), _root(roots, other)
    roots[max(one, other)] = min(one, other)


@kernel()
def _root(roots: Ints32, item: int) -> int:
    while roots[item] != item:
        roots[item] = roots[roots[item]]
        item = roots[item]
    return item


@kernel()
def labels(roots: Ints32) -> tuple[Ints32, int]:
    """Number the sets of a forest by their lowest items; also how many there are."""
    result, count = np.empty_like(roots), 0
    for item, above in enumerate(roots):
        if above == item:
            result[item] = count
            count += 1
        else:
            result[item] = result[above]
    return result, count


@kernel()
def _ascending(values: Floats, face: Ints32) -> tuple[float, float, float]:
    a, b, c = values[face[0]], values[face[1]], values[face[2]]
    return min(a, b, c), max(min(a, b), min(max(a, b), c)), max(a, b, c)


@kernel()
def _fraction(level: float, a: float, b: float, c: float) -> float:
    """The fraction of a triangle that lies below a level; corners at a <= b <= c."""
    if level >= c:
        return 1.0
    if level < b:
        return (level - a) / (b - a) * ((level - a) / (c - a))
    return 1 - (c - level) / (c - b) * ((c - level) / (c - a))


@kernel()
def _links(crossings: _Crossings, part: Ints32, count: int) -> Ints32:
    steps = crossings.first[-1] - len(crossings.low)
    low, high = np.empty(steps, np.int32), np.empty(steps, np.int32)
    filled = 0
    for edge in range(len(crossings.low)):
        for crossing in range(crossings.first[edge], crossings.first[edge + 1] - 1):
            low[filled], high[filled] = part[crossing], part[crossing + 1]
            filled += 1
    return distinct(low, high, count)


@kernel()
def distinct(low: Ints32, high: Ints32, bound: int) -> Ints32:
    """The distinct pairs among pairs of numbers below `bound`, (n, 2), sorted."""
    result, count = np.empty((len(low), 2), np.int32), 0
    for i in lexicographic(low, high, bound):
        if count == 0 or result[count - 1, 0] != low[i] or result[count - 1, 1] != high[i]:
            result[count, 0], result[count, 1] = low[i], high[i]
            count += 1
    return result[:count].copy()


def outer_shell(vertices: Floats, faces: Ints32) -> Ints32:
    """The faces of a body without the walls of its cavities; other pieces are rejected."""
    shells = _shells(faces, len(vertices))
    count = shells.max() + 1
    if count == 1:
        return faces
    corners = vertices[faces]
    sizes = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    largest = np.bincount(shells, sizes).argmax()
    own = shells == largest
    low, high = corners[own].min(axis=(0, 1)), corners[own].max(axis=(0, 1))
    volumes = np.bincount(shells, np.linalg.det(corners - (low + high) / 2))
    hollow = volumes * volumes[largest] <= _SPECK * volumes[largest] ** 2
    inside = ((corners >= low) & (corners <= high)).all(axis=(1, 2))
    if not (own | (hollow[shells] & inside)).all():
        raise RejectedError("the mesh is not one connected piece")
    return np.asarray(faces[own])


@kernel()
def _shells(faces: Ints32, count: int) -> Ints32:
    """Number of the connected piece that each face belongs to."""
    roots = np.arange(count).astype(np.int32)
    for a, b, c in faces:
        unite(roots, a, b)
        unite(roots, a, c)
    met, _ = labels(roots)
    numbers, result, used = np.full(count, -1, np.int32), np.empty(len(faces), np.int32), 0
    for face, (a, _, _) in enumerate(faces):
        if numbers[met[a]] < 0:
            numbers[met[a]] = used
            used += 1
        result[face] = numbers[met[a]]
    return result

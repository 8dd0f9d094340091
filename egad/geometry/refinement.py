"""Edges of a triangle mesh, and its refinement by splitting the longest of them."""

from typing import NamedTuple

import numpy as np

from egad._util.arrays import Floats, Ints, Ints32
from egad._util.kernels import kernel


class Triangulation(NamedTuple):
    """A triangle mesh with its edges numbered. Any number of faces may meet at an edge."""

    vertices: Floats  # (n, 3)
    faces: Ints32  # (f, 3)
    edges: Ints32  # (e, 2)
    face_edges: Ints32  # (f, 3): edge k of a face joins its corners k and k + 1


class _Room(NamedTuple):
    """A triangulation with spare capacity, and which face corners lie at the start of an edge."""

    vertices: Floats
    faces: Ints32
    edges: Ints32
    face_edges: Ints32
    lengths: Floats  # squared
    first: Ints32  # of each edge: corner 3 * face + k of one of its faces
    following: Ints32  # of each corner: the next one of the same edge, or -1


def distinct_corners(faces: Ints) -> Ints32:
    """The faces (f, 3) with three different vertices."""
    a, b, c = faces.T
    distinct = (a != b) & (b != c) & (c != a)
    return np.asarray(faces[distinct], np.int32)


@kernel()
def triangulation(vertices: Floats, faces: Ints32) -> Triangulation:
    """Number the edges of a mesh by their vertices; each face has three different ones."""
    count = 3 * len(faces)
    low, high = np.empty(count, np.int32), np.empty(count, np.int32)
    for corner in range(count):
        one = faces[corner // 3, corner % 3]
        other = faces[corner // 3, (corner + 1) % 3]
        low[corner], high[corner] = min(one, other), max(one, other)
    order = lexicographic(low, high, len(vertices))
    edges, face_edges = np.empty((count, 2), np.int32), np.empty((len(faces), 3), np.int32)
    edge = -1
    for corner in order:
        if edge < 0 or low[corner] != edges[edge, 0] or high[corner] != edges[edge, 1]:
            edge += 1
            edges[edge, 0], edges[edge, 1] = low[corner], high[corner]
        face_edges[corner // 3, corner % 3] = edge
    return Triangulation(vertices, faces, edges[: edge + 1].copy(), face_edges)


@kernel()
def lexicographic(low: Ints32, high: Ints32, bound: int) -> Ints:
    """Indices that sort pairs of numbers below `bound`: a counting sort by each, stable."""
    order = np.arange(len(low))
    for keys in (high, low):
        place = np.zeros(bound + 1, np.int64)
        for key in keys:
            place[key + 1] += 1
        place = np.cumsum(place)
        result = np.empty_like(order)
        for item in order:
            result[place[keys[item]]] = item
            place[keys[item]] += 1
        order = result
    return order


@kernel()
def face_areas(mesh: Triangulation) -> Floats:
    """Area of each face, (f,)."""
    result = np.empty(len(mesh.faces))
    for face, (a, b, c) in enumerate(mesh.faces):
        square = 0.0
        for i in range(3):
            j = (i + 1) % 3
            u, v = (
                mesh.vertices[b, i] - mesh.vertices[a, i],
                mesh.vertices[c, i] - mesh.vertices[a, i],
            )
            p, q = (
                mesh.vertices[b, j] - mesh.vertices[a, j],
                mesh.vertices[c, j] - mesh.vertices[a, j],
            )
            square += (u * q - v * p) ** 2
        result[face] = np.sqrt(square) / 2
    return result


@kernel()
def refine(mesh: Triangulation, count: int) -> Triangulation:
    """Repeatedly split the longest edge, the first of equal ones, up to `count` vertices."""
    start = len(mesh.vertices)
    if start >= count:
        return mesh
    room = _room(mesh, count - start)
    faces, edges = len(mesh.faces), len(mesh.edges)
    heap = np.arange(len(room.edges)).astype(np.int32)  # all edges, the longest on top
    for slot in range(edges // 2, -1, -1):
        _sink(heap, edges, room.lengths, slot)
    end = start
    while end < count and room.lengths[heap[0]] > 0.0:
        middle = end
        end += 1
        added = _split(room, heap[0], middle, faces, edges)
        _sink(heap, edges, room.lengths, 0)
        for edge in range(edges, edges + added + 1):
            _rise(heap, room.lengths, edge)
        faces += added
        edges += added + 1
    return Triangulation(
        room.vertices[:end], room.faces[:faces], room.edges[:edges], room.face_edges[:faces]
    )


@kernel()
def _room(mesh: Triangulation, splits: int) -> _Room:
    first = np.full(len(mesh.edges), -1, np.int32)
    following = np.empty(mesh.face_edges.size, np.int32)
    meeting = np.zeros(len(mesh.edges), np.int64)
    for corner, edge in enumerate(mesh.face_edges.ravel()):
        following[corner], first[edge] = first[edge], corner
        meeting[edge] += 1
    more = splits * max(2, meeting.max())
    lengths = np.empty(len(mesh.edges) + more + splits)
    room = _Room(
        np.concatenate((mesh.vertices, np.empty((splits, 3)))),
        np.concatenate((mesh.faces, np.empty((more, 3), np.int32))),
        np.concatenate((mesh.edges, np.empty((more + splits, 2), np.int32))),
        np.concatenate((mesh.face_edges, np.empty((more, 3), np.int32))),
        lengths,
        np.concatenate((first, np.full(more + splits, -1, np.int32))),
        np.concatenate((following, np.empty(3 * more, np.int32))),
    )
    for number in range(len(mesh.edges)):
        _set_edge(room, number, mesh.edges[number, 0], mesh.edges[number, 1])
    return room


@kernel()
def _set_edge(room: _Room, edge: int, one: int, other: int) -> None:
    room.edges[edge, 0], room.edges[edge, 1] = one, other
    room.lengths[edge] = 0.0
    for k in range(3):
        room.lengths[edge] += (room.vertices[one, k] - room.vertices[other, k]) ** 2


@kernel()
def _split(room: _Room, edge: int, middle: int, faces: int, edges: int) -> int:
    """Split an edge, which keeps its first half, at the vertex `middle`; the count of new faces."""
    one, other = room.edges[edge]
    for k in range(3):
        room.vertices[middle, k] = (room.vertices[one, k] + room.vertices[other, k]) / 2
    second = edges
    corner = int(room.first[edge])
    room.first[edge] = -1
    _set_edge(room, edge, one, middle)
    _set_edge(room, second, middle, other)
    added = 0
    while corner >= 0:
        later = int(room.following[corner])
        forward = room.faces[corner // 3, corner % 3] == one
        halves = (edge, second) if forward else (second, edge)
        _split_face(room, corner, middle, halves, faces + added, edges + 1 + added)
        added += 1
        corner = later
    return added


@kernel()
def _split_face(
    room: _Room, corner: int, middle: int, halves: tuple[int, int], new: int, across: int
) -> None:
    """Cut a face from the midpoint of edge k = (a, b) to c: it becomes a-m-c, the new one m-b-c."""
    face, k = corner // 3, corner % 3
    k1, k2 = (k + 1) % 3, (k + 2) % 3
    b, c = room.faces[face, k1], room.faces[face, k2]
    kept, old = room.face_edges[face], room.face_edges[face, k1]
    room.faces[new, 0], room.faces[new, 1], room.faces[new, 2] = middle, b, c
    cut = room.face_edges[new]
    cut[0], cut[1], cut[2] = halves[1], old, across
    room.faces[face, k1] = middle
    kept[k], kept[k1] = halves[0], across
    _set_edge(room, across, middle, c)
    _move(room, old, 3 * face + k1, 3 * new + 1)
    _join(room, halves[0], corner)
    _join(room, halves[1], 3 * new)
    _join(room, across, 3 * face + k1)
    _join(room, across, 3 * new + 2)


@kernel()
def _join(room: _Room, edge: int, corner: int) -> None:
    room.following[corner], room.first[edge] = room.first[edge], corner


@kernel()
def _move(room: _Room, edge: int, corner: int, to: int) -> None:
    """An edge meets corner `to` in place of another one."""
    room.following[to] = room.following[corner]
    if room.first[edge] == corner:
        room.first[edge] = to
        return
    place = room.first[edge]
    while room.following[place] != corner:
        place = room.following[place]
    room.following[place] = to


@kernel()
def _above(lengths: Floats, one: int, other: int) -> bool:
    if lengths[one] == lengths[other]:
        return one < other
    return bool(lengths[one] > lengths[other])


@kernel()
def _sink(heap: Ints32, count: int, lengths: Floats, slot: int) -> None:
    item = heap[slot]
    while 2 * slot + 1 < count:
        child = 2 * slot + 1
        if child + 1 < count and _above(lengths, heap[child + 1], heap[child]):
            child += 1
        if not _above(lengths, heap[child], item):
            break
        heap[slot] = heap[child]
        slot = child
    heap[slot] = item


@kernel()
def _rise(heap: Ints32, lengths: Floats, slot: int) -> None:
    item = heap[slot]
    while slot > 0 and _above(lengths, item, heap[(slot - 1) // 2]):
        heap[slot] = heap[(slot - 1) // 2]
        slot = (slot - 1) // 2
    heap[slot] = item

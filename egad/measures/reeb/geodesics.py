"""Geodesic distances, and their integral mu, the function that Reeb graphs are built from.

mu(v) is the integral of the geodesic distance to v over the surface (Hilaga et al., "Topology
Matching for Fully Automatic Similarity Estimation of 3D Shapes", SIGGRAPH 2001). It is computed as
a sum over base vertices that represent parts of it.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from egad._util.arrays import Floats, Ints, Ints32
from egad._util.kernels import kernel
from egad.geometry import Triangulation
from egad.measures.reeb.sweeps import order_of, weighted_distances

_WIDTH = 0.25  # of a bucket, in mean edge lengths: measured to be the fastest
_ABSENT = -(1 << 30)  # in `preceding`: in no bucket


class EdgeGraph(NamedTuple):
    """The edges at each vertex, row by row, and buckets; unsigned, which saves index checks."""

    starts: NDArray[np.uint32]  # (n + 1,) of the rows
    neighbors: NDArray[np.uint32]  # (2 e,)
    lengths: Floats  # (2 e,)
    scale: float  # buckets per unit of length
    first: Ints32  # (power of 2,): the first vertex in each bucket, or -1
    following: Ints32  # (n,): the next vertex of the same bucket, or -1
    preceding: Ints32  # (n,): the one before, or -1 - bucket


@kernel()
def edge_graph(mesh: Triangulation, shortcuts: bool) -> EdgeGraph:
    """The graph of the edges of a mesh, ready for searches.

    With shortcuts, a path may also cross two faces from corner to corner (Hilaga et al. 2001), so
    that distances hardly change when the surface is remeshed.
    """
    ends, lengths = mesh.edges, _lengths(mesh)
    if shortcuts:
        more_ends, more_lengths = _shortcuts(mesh, lengths)
        ends, lengths = np.concatenate((ends, more_ends)), np.concatenate((lengths, more_lengths))
    count = len(mesh.vertices)
    starts = np.zeros(count + 1, np.int64)
    for end in ends.ravel():
        starts[end + 1] += 1
    starts = np.cumsum(starts)
    place = starts[:-1].copy()
    neighbors, distances = np.empty(ends.size, np.uint32), np.empty(ends.size)
    for edge in range(len(ends)):
        for k in range(2):
            row = place[ends[edge, k]]
            neighbors[row], distances[row] = ends[edge, 1 - k], lengths[edge]
            place[ends[edge, k]] += 1
    width = _WIDTH * lengths.mean()
    buckets = 2 ** int(np.ceil(np.log2(lengths.max() / width + 2)))
    first = np.full(buckets, -1, np.int32)
    following, preceding = np.empty(count, np.int32), np.empty(count, np.int32)
    return EdgeGraph(
        starts.astype(np.uint32), neighbors, distances, 1 / width, first, following, preceding
    )


@kernel()
def _lengths(mesh: Triangulation) -> Floats:
    lengths = np.zeros(len(mesh.edges))
    for edge, (one, other) in enumerate(mesh.edges):
        for k in range(3):
            lengths[edge] += (mesh.vertices[one, k] - mesh.vertices[other, k]) ** 2
    return np.sqrt(lengths)


@kernel()
def _shortcuts(mesh: Triangulation, lengths: Floats) -> tuple[Ints32, Floats]:
    """Straight lines across an edge, between the far corners of its two faces laid flat."""
    count = len(mesh.edges)
    far, faces = np.empty((count, 2), np.int32), np.zeros(count, np.int32)
    for face in range(len(mesh.faces)):
        for k in range(3):
            edge = mesh.face_edges[face, k]
            if faces[edge] < 2:
                far[edge, faces[edge]] = mesh.faces[face, (k + 2) % 3]
            faces[edge] += 1
    result, used = np.empty(count), np.zeros(count, np.bool_)
    for edge in range(count):
        if faces[edge] == 2 and lengths[edge] > 0 and far[edge, 0] != far[edge, 1]:
            one, other = mesh.edges[edge]
            x0, y0 = _flat(mesh.vertices, one, other, far[edge, 0], lengths[edge])
            x1, y1 = _flat(mesh.vertices, one, other, far[edge, 1], lengths[edge])
            crossing = x0 * y1 + x1 * y0
            used[edge] = 0 < crossing < lengths[edge] * (y0 + y1)
            result[edge] = np.sqrt((x0 - x1) ** 2 + (y0 + y1) ** 2)
    return far[used], result[used]


@kernel()
def _flat(
    vertices: Floats, one: int, other: int, corner: int, length: float
) -> tuple[float, float]:
    """Position of a corner along an edge, and its distance from the edge's line."""
    along = square = 0.0
    for k in range(3):
        arm = vertices[corner, k] - vertices[one, k]
        along += arm * (vertices[other, k] - vertices[one, k])
        square += arm * arm
    along /= length
    return along, np.sqrt(max(square - along * along, 0.0))


@kernel()
def spread(graph: EdgeGraph, source: int, distances: Floats) -> None:
    """Lower the distances of all vertices that a path from the source brings nearer, in place."""
    starts, neighbors, lengths, scale, first, following, preceding = graph
    mask = len(first) - 1
    preceding[:] = _ABSENT
    distances[source] = 0.0
    first[0], following[source], preceding[source] = source, -1, -1
    waiting, turn = 1, 0
    while waiting > 0:
        vertex = first[turn & mask]
        if vertex < 0:
            turn += 1
            continue
        after = following[vertex]
        first[turn & mask] = after
        if after >= 0:
            preceding[after] = -1 - (turn & mask)
        preceding[vertex] = _ABSENT
        waiting -= 1
        travelled = distances[vertex]
        for i in range(starts[vertex], starts[vertex + 1]):
            neighbor, distance = neighbors[i], travelled + lengths[i]
            if distance >= distances[neighbor]:
                continue
            distances[neighbor] = distance
            bucket = int(distance * scale) & mask
            before, after = preceding[neighbor], following[neighbor]
            if before == _ABSENT:
                waiting += 1
            else:  # unlink it from its bucket
                if before >= 0:
                    following[before] = after
                else:
                    first[-1 - before] = after
                if after >= 0:
                    preceding[after] = before
            after = first[bucket]
            first[bucket], following[neighbor], preceding[neighbor] = (neighbor, after, -1 - bucket)
            if after >= 0:
                preceding[after] = neighbor


@kernel()
def even_integral(
    graph: EdgeGraph, vertices: Floats, faces: Ints32, areas: Floats, count: int
) -> Floats:
    """The integral (n,) from farthest-point bases (ours), each for the vertices nearest to it."""
    share = _shares(faces, areas, len(vertices))
    bases, owner, order = _farthest(graph, _farthest_from_center(vertices, share), count)
    weights = np.zeros(len(bases))
    for vertex, area in enumerate(share):
        weights[owner[vertex]] += area
    return weighted_distances(graph.starts, graph.neighbors, graph.lengths, order, bases, weights)


@kernel()
def _farthest(graph: EdgeGraph, base: int, count: int) -> tuple[Ints, Ints, Ints]:
    """Farthest-point bases, the first nearest base of each vertex, vertices from the first on."""
    vertices = len(graph.starts) - 1
    nearest, before = np.full(vertices, np.inf), np.full(vertices, np.inf)
    owner, order = np.zeros(vertices, np.int64), np.empty(vertices, np.int64)
    bases, used = np.empty(min(count, vertices), np.int64), 0
    while used < len(bases) and nearest[base] > 0:
        bases[used] = base
        spread(graph, base, nearest)
        if used == 0:
            order[:] = order_of(nearest)
        base = _claim(nearest, before, owner, used)
        used += 1
    return bases[:used], owner, order


@kernel()
def _shares(faces: Ints32, areas: Floats, count: int) -> Floats:
    """Area of the surface that belongs to each vertex: a third of each of its faces."""
    share = np.zeros(count)
    for face, area in enumerate(areas):
        for vertex in faces[face]:
            share[vertex] += area / 3
    return share


@kernel()
def _farthest_from_center(vertices: Floats, share: Floats) -> int:
    squares = np.zeros(len(vertices))
    for k in range(3):
        center = np.sum(vertices[:, k] * share) / np.sum(share)
        squares += (vertices[:, k] - center) ** 2
    return int(np.argmax(squares))


@kernel()
def _claim(nearest: Floats, before: Floats, owner: Ints, number: int) -> int:
    """Assign vertices that are nearer than before to a base; returns the one farthest from all."""
    farthest = 0
    for vertex, distance in enumerate(nearest):
        if distance < before[vertex]:
            owner[vertex], before[vertex] = number, distance
        if distance > nearest[farthest]:
            farthest = vertex
    return farthest


@kernel()
def scan_integral(graph: EdgeGraph, faces: Ints32, areas: Floats, radius: float) -> Floats:
    """The integral (n,) from the bases of the program that the published values come from.

    Vertices are visited in order: one not covered yet becomes a base, covers those within the
    radius, and represents all faces with a vertex that it is the first to cover, so order matters.
    """
    count = len(graph.starts) - 1
    result, distances = np.zeros(count), np.empty(count)
    owner = np.full(count, -1)
    for base in range(count):
        if owner[base] < 0:
            distances[:] = np.inf
            spread(graph, base, distances)
            owner[(owner < 0) & (distances <= radius)] = base
            result += _patch(faces, areas, owner, base) * distances
    return result


@kernel()
def _patch(faces: Ints32, areas: Floats, owner: Ints, base: int) -> float:
    """Area of the faces that have a vertex of a base."""
    total = 0.0
    for face, area in enumerate(areas):
        for vertex in faces[face]:
            if owner[vertex] == base:
                total += area
                break
    return total

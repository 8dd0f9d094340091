"""Shortest paths along the edges of a mesh.

The queue is that of Dial ("Algorithm 360", CACM 1969): a ring of buckets. Here a bucket may be wider
than the shortest edge, as a vertex that gets a better distance is simply expanded again; so the
distances are exact, and the same for every width.
"""

from typing import NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from egad.measures.refine import Triangulation

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]

_WIDTH = 0.25  # of a bucket, in mean edge lengths: measured to be the fastest
_ABSENT = -(1 << 30)  # in `preceding`: in no bucket


class EdgeGraph(NamedTuple):
    """The edges at each vertex, row by row, and the buckets that vertices wait in."""

    starts: Ints  # (n + 1,) of the rows
    neighbours: Ints  # (2 e,)
    lengths: Floats  # (2 e,)
    scale: float  # buckets a unit of length
    first: Ints  # (power of 2,): the first vertex in each bucket, or -1
    following: Ints  # (n,): the next vertex of the same bucket, or -1
    preceding: Ints  # (n,): the one before, or -1 - bucket


@numba.njit(cache=True)
def edge_graph(mesh: Triangulation) -> EdgeGraph:
    """The graph of the edges of a mesh, ready for searches."""
    count = len(mesh.vertices)
    starts = np.zeros(count + 1, np.int64)
    for end in mesh.edges.ravel():
        starts[end + 1] += 1
    starts = np.cumsum(starts)
    place = starts[:-1].copy()
    neighbours, lengths = np.empty(2 * len(mesh.edges), np.int32), np.empty(2 * len(mesh.edges))
    for edge in range(len(mesh.edges)):
        one, other = mesh.edges[edge]
        square = 0.0
        for k in range(3):
            square += (mesh.vertices[one, k] - mesh.vertices[other, k]) ** 2
        neighbours[place[one]], neighbours[place[other]] = other, one
        lengths[place[one]] = lengths[place[other]] = np.sqrt(square)
        place[one] += 1
        place[other] += 1
    width = _WIDTH * lengths.mean()
    buckets = 2 ** int(np.ceil(np.log2(lengths.max() / width + 2)))
    first = np.full(buckets, -1, np.int32)
    following, preceding = np.empty(count, np.int32), np.empty(count, np.int32)
    return EdgeGraph(
        starts.astype(np.int32), neighbours, lengths, 1 / width, first, following, preceding
    )


@numba.njit(cache=True)
def spread(graph: EdgeGraph, source: int, distances: Floats) -> None:
    """Lower the distances of all vertices that a path from the source brings nearer, in place.

    Distances that are infinite everywhere become those to the source; those to the nearest of
    some vertices become those to the nearest of these and the source, and the search ends where
    it brings nothing nearer.
    """
    starts, neighbours, lengths, scale, first, following, preceding = graph
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
            neighbour, distance = neighbours[i], travelled + lengths[i]
            known = distances[neighbour]
            if distance >= known:
                continue
            distances[neighbour] = distance
            bucket = int(distance * scale) & mask
            before, after = preceding[neighbour], following[neighbour]
            if before == _ABSENT:
                waiting += 1
            elif bucket == int(known * scale) & mask:
                continue
            else:  # unlink it from its bucket
                if before >= 0:
                    following[before] = after
                else:
                    first[-1 - before] = after
                if after >= 0:
                    preceding[after] = before
            after = first[bucket]
            first[bucket], following[neighbour], preceding[neighbour] = (
                neighbour,
                after,
                -1 - bucket,
            )
            if after >= 0:
                preceding[after] = neighbour

"""Shortest paths from many vertices at once.

A separate search from each vertex, the nearest vertices first, spends most of its time on branches
that a processor cannot predict. Here, all vertices are visited in one order for all sources, back
and forth, until no distance gets lower, and an edge serves all sources with a few wide
instructions.

A distance is the least sum of lengths along a path, added up from the source. Sums that are rounded
keep their order when a length is added to both, so the order of the visits does not matter.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from egad._util.arrays import Flags, Floats, Ints
from egad._util.kernels import kernel

LANES = 52  # sources of a row: 13 registers of four numbers; most processors have 16
Indices = NDArray[np.uint32]


class VertexEdges(NamedTuple):
    """Edges at each vertex: first those to the vertices before it, then those to later ones."""

    starts: Ints  # (n + 1,)
    middles: Ints  # (n,): first of the edges to later vertices
    neighbors: Indices  # (2 e,)
    lengths: Floats  # (2 e,)


@kernel()
def order_of(distances: Floats) -> Ints:
    """Vertices in about the order of their distances, (n,): unreachable ones come last."""
    count, largest = len(distances), 0.0
    for distance in distances:
        if largest < distance < np.inf:
            largest = distance
    steps, starts = np.full(count, count), np.zeros(count + 2, np.int64)
    for vertex, distance in enumerate(distances):
        if distance < np.inf:
            steps[vertex] = int(distance / largest * (count - 1)) if largest > 0 else 0
        starts[steps[vertex] + 1] += 1
    starts = np.cumsum(starts)
    result = np.empty(count, np.int64)
    for vertex, step in enumerate(steps):
        result[starts[step]] = vertex
        starts[step] += 1
    return result


@kernel()
def weighted_distances(
    starts: Indices,
    neighbors: Indices,
    lengths: Floats,
    order: Ints,
    sources: Ints,
    weights: Floats,
) -> Floats:
    """Sum (n,) of weighted distances of each vertex to all sources, one added after the other."""
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    rows = renumber(starts, neighbors, lengths, order, rank)
    result = np.zeros(len(order))
    for first in range(0, len(sources), LANES):
        distances = sweep(rows, rank[sources[first : first + LANES]])
        for place, vertex in enumerate(order):
            total = result[vertex]
            for i, weight in enumerate(weights[first : first + LANES]):
                total += weight * distances[place, i]
            result[vertex] = total
    return result


@kernel()
def renumber(
    starts: Indices, neighbors: Indices, lengths: Floats, order: Ints, rank: Ints
) -> VertexEdges:
    """Edges row by row with vertices renumbered: `rank` has the new numbers, `order` the old."""
    result = VertexEdges(
        np.zeros(len(order) + 1, np.int64),
        np.empty(len(order), np.int64),
        np.empty_like(neighbors),
        np.empty_like(lengths),
    )
    for place, vertex in enumerate(order):
        low = result.starts[place]
        high = low + starts[vertex + 1] - starts[vertex]
        result.starts[place + 1] = high
        for edge in range(starts[vertex], starts[vertex + 1]):
            neighbor = rank[neighbors[edge]]
            before = neighbor < place
            slot = low if before else high - 1
            low, high = low + before, high - 1 + before
            result.neighbors[slot], result.lengths[slot] = neighbor, lengths[edge]
        result.middles[place] = low
    return result


@kernel()
def sweep(rows: VertexEdges, sources: Ints) -> Floats:
    """Distances (n, LANES) of all vertices to at most LANES sources; infinite without a source.

    Only half of the edges are needed in each direction: others cannot have changed since the way
    back.
    """
    count = len(rows.middles)
    distances = np.full((count, LANES), np.inf)
    ahead, back = np.zeros(count, np.bool_), np.zeros(count, np.bool_)  # to be visited on that way
    for column, source in enumerate(sources):
        distances[source, column] = 0.0
        _mark(rows, source, ahead, back)
    waiting = True
    while waiting:
        waiting = False
        for vertex in range(count):
            if ahead[vertex]:
                ahead[vertex] = False
                start, end = rows.starts[vertex], rows.middles[vertex]
                if lower(distances, vertex, rows.neighbors, rows.lengths, start, end):
                    _mark(rows, vertex, ahead, back)
        for vertex in range(count - 1, -1, -1):
            if back[vertex]:
                back[vertex] = False
                start, end = rows.middles[vertex], rows.starts[vertex + 1]
                if lower(distances, vertex, rows.neighbors, rows.lengths, start, end):
                    _mark(rows, vertex, ahead, back)
                    waiting = True
    return distances


@kernel(inline="always")
def _mark(rows: VertexEdges, vertex: int, ahead: Flags, back: Flags) -> None:
    """Mark the neighbors of a vertex for a visit: later ones on the way forward, others back."""
    for edge in range(rows.starts[vertex], rows.middles[vertex]):
        back[rows.neighbors[edge]] = True
    for edge in range(rows.middles[vertex], rows.starts[vertex + 1]):
        ahead[rows.neighbors[edge]] = True


@kernel(fastmath={"nnan", "nsz"})
def lower(
    distances: Floats,
    vertex: int,
    neighbors: NDArray[np.uint32],
    lengths: Floats,
    start: int,
    end: int,
) -> bool:
    """Lower the distances (LANES,) of a vertex to those via neighbors; returns whether any was."""
    own = distances[vertex]
    lowered = False
    for index in range(start, end):
        row = distances[neighbors[index]]
        length = lengths[index]
        for lane in range(LANES):
            through = row[lane] + length
            lowered |= through < own[lane]
            own[lane] = min(own[lane], through)
    return lowered

"""Many Reeb graphs in flat arrays for compiled code, and the working memory of their matching."""

import hashlib
from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from egad._util.arrays import Floats, Ints32
from egad._util.kernels import kernel
from egad.errors import UserError
from egad.measures.reeb.graph import ReebGraph

MAX_MATCHED = 5  # largest number of nodes that one node may be matched to


class Nodes(NamedTuple):
    """Nodes of many graphs in one row; in each graph the coarsest one is the last."""

    values: Floats  # (n, 2): weighted area and length
    around: Floats  # (n, 4): their sums over the neighbors below, and above
    rows: Ints32  # (n, 5): where in `links` a node's children begin, those in the upper half of its
    # range begin, and all of them end; where its neighbors begin and end
    links: Ints32


class MatchingMemory(NamedTuple):
    """Memory for matchings; separate arrays in place of rows of one would slow each call down."""

    ints: Ints32  # (_ROWS, 2 n): a row for each purpose below


STATE = 0  # numbers of matches, of their nodes and of visits; what to add to nodes of either graph
FREE = 1  # by shifted node: whether it may still be matched in this group
SEEN = 2  # likewise: last visit as a neighbor that runs are taken from
ADDED = 3  # likewise: last visit as a neighbor of a run
MATCHED = 4  # nodes of all matches
FIRST, SECOND, END = 5, 6, 7  # by match: where in MATCHED either side begins, and where it ends
SIDE = 8  # and 9: nodes of a group
ORDER = 10  # of these by size: index in the first side, or -1 - index in the second
LINE = 11  # nodes that runs are cut from
CHOSEN = 12  # best partners so far
_ROWS = 13


@kernel()
def space(starts: Ints32) -> MatchingMemory:
    """Memory to match any two of the graphs that start at these nodes (the last one is the end)."""
    largest = 0
    for i in range(len(starts) - 1):
        largest = max(largest, starts[i + 1] - starts[i])
    return MatchingMemory(np.zeros((_ROWS, max(2 * largest, MAX_MATCHED)), np.int32))


class Trees(NamedTuple):
    """The arrays of a forest of t graphs."""

    nodes: Nodes
    starts: Ints32  # (t + 1,): first node of each graph
    keys: NDArray[np.uint64]  # (t,): equal for equal graphs only
    levels: int
    profiles: Floats  # (t, p): weighted area, then length, of each range of each level


class Forest:
    """Graphs to be compared, numbered in the order in which they were added."""

    def __init__(self, weight: float, graphs: Iterable[ReebGraph] = ()) -> None:
        """Make a forest; `weight` is that of area against length in the value of a node, 0 to 1."""
        self._weights = np.array([weight, 1 - weight])
        self._levels: set[int] = set()
        self._values, self._around = _Rows(np.empty((0, 2))), _Rows(np.empty((0, 4)))
        self._rows, self._links = _Rows(np.empty((0, 5), np.int32)), _Rows(np.empty(0, np.int32))
        self._starts, self._keys = _Rows(np.zeros(1, np.int32)), _Rows(np.empty(0, np.uint64))
        self._profiles = _Rows(np.empty((0, 0)))
        self.extend(graphs)

    def __len__(self) -> int:
        return len(self._keys.view)

    def extend(self, graphs: Iterable[ReebGraph]) -> None:
        """Add graphs; `UserError` if they have another number of ranges than those already here."""
        graphs = list(graphs)
        levels = self._levels | {len(graph.level_starts) for graph in graphs}
        if len(levels) > 1:
            raise UserError("Reeb graphs with different numbers of ranges cannot be compared.")
        self._levels = levels
        for graph in graphs:
            values = np.stack((graph.areas, graph.lengths), axis=1) * self._weights
            start = len(self._values.view)
            links = np.concatenate((graph.children, graph.neighbors)) + start
            self._rows.extend(_rows(graph) + len(self._links.view))
            self._links.extend(links)
            self._values.extend(values)
            self._around.extend(_around(graph.neighbor_starts, graph.neighbors, values))
            self._profiles.extend(_profile(graph, values)[None])
            self._starts.extend(np.array([start + len(values)], np.int32))
            self._keys.extend(np.array([_key(graph)]))

    @property
    def trees(self) -> Trees:
        """The arrays of all graphs."""
        nodes = Nodes(self._values.view, self._around.view, self._rows.view, self._links.view)
        levels = max(self._levels, default=1) - 1
        return Trees(nodes, self._starts.view, self._keys.view, levels, self._profiles.view)


class _Rows:
    """An array that grows."""

    def __init__(self, first: NDArray[Any]) -> None:
        self._data = first
        self._used = len(first)

    @property
    def view(self) -> NDArray[Any]:
        return self._data[: self._used]

    def extend(self, rows: NDArray[Any]) -> None:
        end = self._used + len(rows)
        if end > len(self._data):
            larger = np.empty((2 * end, *rows.shape[1:]), self._data.dtype)
            if self._used:
                larger[: self._used] = self.view
            self._data = larger
        self._data[self._used : end] = rows
        self._used = end


def _key(graph: ReebGraph) -> np.uint64:
    """A digest of the contents of a graph, by which two graphs are ordered."""
    digest = hashlib.blake2b(digest_size=8)
    for array in (graph.areas, graph.lengths, graph.ranges, graph.neighbors):
        digest.update(array.tobytes())
    return np.uint64(int.from_bytes(digest.digest(), "little"))


def _rows(graph: ReebGraph) -> Ints32:
    """`Nodes.rows` of a single graph, with its neighbors after its children."""
    lower = graph.ranges[graph.children] % 2 == 0
    before = np.concatenate(([0], np.cumsum(lower)))
    starts, ends = graph.child_starts[:-1], graph.child_starts[1:]
    middles = starts + before[ends] - before[starts]
    neighbors = graph.neighbor_starts + len(graph.children)
    rows = np.stack((starts, middles, ends, neighbors[:-1], neighbors[1:]), axis=1)
    return rows.astype(np.int32)


def _profile(graph: ReebGraph, values: Floats) -> Floats:
    """The sum of the values over each range of each level: all areas, then all lengths."""
    levels = len(graph.level_starts) - 1
    firsts = 2**levels - 2 ** np.arange(levels, 0, -1)
    place = np.repeat(firsts, np.diff(graph.level_starts)) + graph.ranges
    sums = [np.bincount(place, column, 2**levels - 1) for column in values.T]
    return np.concatenate(sums)


@kernel()
def _around(starts: Ints32, neighbors: Ints32, values: Floats) -> Floats:
    """Sums of values over the neighbors of each node in the range below, and above."""
    result = np.zeros((len(values), 4))
    for node in range(len(values)):
        for neighbor in neighbors[starts[node] : starts[node + 1]]:
            place = 0 if neighbor < node else 2
            for k in range(2):
                result[node, place + k] += values[neighbor, k]
    return result

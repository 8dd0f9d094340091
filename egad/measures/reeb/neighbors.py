"""Exact nearest neighbors among shapes, with few comparisons, as shapes are added and removed.

Comparing two Reeb graphs is expensive, but a bound on their similarity is cheap. Candidates are
compared in the order of the bound until none of the remaining ones can be near enough; a comparison
stops as soon as it shows that the candidate is not. The bounds are ours. Several shapes are looked
up at once, each by a thread that writes only to the row of that shape, so the results do not depend
on the threads.
"""

import heapq
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from egad._util.arrays import Floats, Ints
from egad._util.kernels import kernel
from egad.measures.reeb.forest import Forest, MatchingMemory, Trees, space
from egad.measures.reeb.graph import ReebGraph
from egad.measures.reeb.similarity import SLACK, bound, compare

Bytes = NDArray[np.uint8]
Watch = Callable[[list[Ints]], Iterable[Ints]]

_UNKNOWN, _BOUND, _COMPARED, _EXACT = 0, 1, 2, 3  # compared: a bound that is worth keeping

CHUNK, ROUND = 4, 16  # shapes that a thread looks up at once; before it tells the other shapes
SPARE = 100  # graphs of removed shapes that may stay in a small forest


def diversities(
    graphs: Sequence[ReebGraph],
    weight: float,
    neighbors: int,
    threads: int = 1,
    watch: Watch = iter,
) -> Floats:
    """Diversity of each of n shapes among the others, (n,); `watch` passes batches through."""
    neighborhood = Neighborhood(weight, neighbors, threads)
    found = neighborhood.diversities(neighborhood.add(graphs), watch)
    return np.array(found, dtype=np.float64)


class Neighborhood:
    """Shapes and their nearest neighbors. A distance is 1 - similarity, computed at most once.

    An index without a shape is a `KeyError`.
    """

    def __init__(self, weight: float, neighbors: int, threads: int = 1) -> None:
        """Start with no shapes; `threads` are looked up at once, which changes no result."""
        self._weight, self._threads = weight, threads
        self._forest = Forest(weight)
        self._graphs: dict[int, ReebGraph] = {}
        self._free: list[int] = []  # a heap: the lowest index is used first
        self._trees = np.empty(0, np.int64)  # number in the forest, -1 if absent
        self._distances = np.empty((0, 0))  # or lower bounds
        self._known = np.empty((0, 0), np.uint8)
        self._near = np.empty((0, neighbors), np.int64)  # padded with -1
        self._valid = np.empty(0, bool)  # of the rows of `_near`
        self._diversities: dict[int, float] = {}  # of valid rows

    def __len__(self) -> int:
        return len(self._graphs)

    def add(self, graphs: Iterable[ReebGraph]) -> list[int]:
        """Add shapes; returns their indices, which may be those of removed shapes."""
        graphs = list(graphs)
        first = len(self._forest)
        self._forest.extend(graphs)
        self._make_room(len(graphs))
        indices = [heapq.heappop(self._free) for _ in graphs]
        self._graphs.update(zip(indices, graphs, strict=True))
        self._trees[indices] = np.arange(first, len(self._forest))
        self._known[indices] = self._known[:, indices] = _UNKNOWN
        self._valid[:] = False
        self._diversities.clear()
        return indices

    def remove(self, index: int) -> None:
        """Remove a shape."""
        del self._graphs[index]
        self._trees[index] = -1
        heapq.heappush(self._free, index)
        self._valid[index] = False
        stale = np.flatnonzero((self._near == index).any(axis=1) & self._valid).tolist()
        self._valid[stale] = False
        for row in (index, *stale):
            self._diversities.pop(row, None)
        if len(self._forest) > 2 * len(self) + SPARE:
            self._replant()

    def distance(self, one: int, other: int) -> float:
        """Distance between two shapes."""
        self._check(one, other)
        if one != other and self._known[one, other] != _EXACT:
            table = self._table
            _measure(table, one, other, np.inf, space(table.trees.starts))
            _tell(table, np.array([one]))
        return float(self._distances[one, other]) if one != other else 0.0

    def nearest(self, index: int) -> tuple[Ints, Floats]:
        """The nearest other shapes and their distances, ascending; ties by index."""
        self._check(index)
        self._look_up([index])
        near = self._near[index][self._near[index] >= 0]
        return near, self._distances[index, near]

    def nearest_to(self, graph: ReebGraph) -> tuple[Ints, Floats]:
        """The nearest shapes to one that is not among them, as in `nearest`."""
        (index,) = self.add([graph])
        near, distances = self.nearest(index)
        self.remove(index)
        return near, distances

    def diversity(self, index: int) -> float:
        """Mean distance of a shape to its nearest ones; 1 if there is no other."""
        if index not in self._diversities:
            _, distances = self.nearest(index)
            self._diversities[index] = float(distances.mean()) if len(distances) else 1.0
        return self._diversities[index]

    def diversities(self, indices: Sequence[int], watch: Watch = iter) -> list[float]:
        """The diversities of several shapes, in parallel; `watch` passes batches through."""
        self._check(*indices)
        self._look_up(indices, watch)
        return [self.diversity(index) for index in indices]

    def _look_up(self, indices: Sequence[int], watch: Watch = iter) -> None:
        """Find the nearest neighbors of the shapes for which they are not known."""
        rows = np.array([i for i in dict.fromkeys(indices) if not self._valid[i]], dtype=np.int64)
        table, others = self._table, np.flatnonzero(self._trees >= 0)

        def search(chunk: Ints) -> None:
            self._near[chunk] = _nearest_to_each(table, chunk, others, self._near.shape[1])

        count = self._threads if len(rows) > CHUNK else 1
        with ThreadPoolExecutor(count) as pool:
            mapper = map if count == 1 else pool.map
            for batch in watch(_cut(rows, ROUND * self._threads)):
                list(mapper(search, _cut(batch, CHUNK)))
                _tell(table, batch)
        self._valid[rows] = True

    @property
    def _table(self) -> "_Table":
        return _Table(self._forest.trees, self._trees, self._distances, self._known)

    def _check(self, *indices: int) -> None:
        for index in indices:
            if index not in self._graphs:
                raise KeyError(index)

    def _make_room(self, count: int) -> None:
        """Make room for `count` more indices."""
        size = len(self._trees)
        needed = len(self) + count
        if needed <= size:
            return
        larger = max(needed, size + size // 4)
        distances, known = np.empty((larger, larger)), np.zeros((larger, larger), np.uint8)
        distances[:size, :size], known[:size, :size] = self._distances, self._known
        self._distances, self._known = distances, known
        more = larger - size
        self._trees = np.pad(self._trees, (0, more), constant_values=-1)
        self._near = np.pad(self._near, ((0, more), (0, 0)), constant_values=-1)
        self._valid = np.pad(self._valid, (0, more))
        self._free.extend(range(size, larger))  # all of these are larger: still a heap

    def _replant(self) -> None:
        """Drop the graphs of removed shapes from the forest."""
        indices = sorted(self._graphs)
        self._forest = Forest(self._weight, [self._graphs[index] for index in indices])
        self._trees[indices] = np.arange(len(indices))


def _cut(rows: Ints, length: int) -> list[Ints]:
    """Split an array into pieces of at most some length."""
    return [rows[start : start + length] for start in range(0, len(rows), length)]


class _Table(NamedTuple):
    """What is known of the distances between m indices."""

    trees: Trees
    numbers: Ints  # (m,): of the graphs in the forest
    distances: Floats  # (m, m): or lower bounds
    known: Bytes  # (m, m)


@kernel(nogil=True)
def _nearest_to_each(table: _Table, rows: Ints, others: Ints, count: int) -> Ints:
    """The nearest of others to each of n indices, the only rows written: (n, count), with -1."""
    result = np.full((len(rows), count), -1)
    memory = space(table.trees.starts)
    for place, index in enumerate(rows):
        near = _nearest(table, index, others[others != index], count, memory)
        result[place, : len(near)] = near
    return result


@kernel()
def _nearest(table: _Table, index: int, others: Ints, count: int, memory: MatchingMemory) -> Ints:
    """The nearest of some other indices; those that cannot be near are not compared."""
    near, found = np.empty(min(count, len(others)), np.int64), 0
    if len(near) == 0:
        return near
    distances, known = table.distances[index], table.known[index]
    for other in others:
        if known[other] == _UNKNOWN:
            _estimate(table, index, other)
        if known[other] == _EXACT:
            found = _insert(near, found, distances, other)
    limit = distances[near[-1]] if found == len(near) else np.inf
    candidates = others[(known[others] != _EXACT) & (distances[others] <= limit)]
    for other in candidates[np.argsort(distances[candidates], kind="mergesort")]:
        limit = distances[near[-1]] if found == len(near) else np.inf
        if distances[other] > limit:
            break
        if _measure(table, index, other, limit, memory):
            found = _insert(near, found, distances, other)
    return near


@kernel()
def _estimate(table: _Table, one: int, other: int) -> None:
    """Keep a lower bound of a distance, for `one` only: computing it again is cheap."""
    most = bound(table.trees.profiles, table.numbers[one], table.numbers[other])
    table.distances[one, other] = 1 - most - SLACK
    table.known[one, other] = _BOUND


@kernel()
def _measure(table: _Table, one: int, other: int, limit: float, memory: MatchingMemory) -> bool:
    """Keep the distance for `one` and return True, or a better bound if it exceeds a limit."""
    numbers = table.numbers[one], table.numbers[other]
    similarity, exact = compare(table.trees, *numbers, 1 - limit - SLACK, memory)
    table.distances[one, other] = 1 - similarity if exact else 1 - similarity - SLACK
    table.known[one, other] = _EXACT if exact else _COMPARED
    return exact


@kernel()
def _tell(table: _Table, rows: Ints) -> None:
    """Copy what was compared for some indices to the other ones, too."""
    distances, known = table.distances, table.known
    for one in rows:
        for other in range(known.shape[1]):
            if known[one, other] < _COMPARED or known[one, other] < known[other, one]:
                continue
            better = distances[one, other] > distances[other, one]
            if better or known[one, other] > known[other, one]:
                distances[other, one], known[other, one] = distances[one, other], known[one, other]


@kernel()
def _insert(near: Ints, found: int, distances: Floats, other: int) -> int:
    """Insert an index by (distance, index) if it is among the nearest; returns their number."""
    slot = min(found, len(near))
    while slot > 0 and (distances[other], other) < (distances[near[slot - 1]], near[slot - 1]):
        if slot < len(near):
            near[slot] = near[slot - 1]
        slot -= 1
    if slot < len(near):
        near[slot] = other
    return min(found + 1, len(near))

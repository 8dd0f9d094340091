"""Exact nearest neighbours by shape, in a set that changes.

Distances are dear and most are never needed: a cheap bound of the similarity tells which pairs can
matter. Every distance that was computed is kept while both members are there.
"""

from collections.abc import Sequence

import numba
import numpy as np
from numpy.typing import NDArray

from egad.measures.forest import Forest
from egad.measures.reeb import ReebGraph
from egad.measures.similarity import similarities

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
SPARE = 500  # graphs of removed members that are kept before the forest is planted anew


class Neighbourhood:
    """The members of a set, and who is nearest to whom (distance = 1 - similarity)."""

    def __init__(self, weight: float, neighbours: int) -> None:
        """Make an empty set.

        Args:
            weight: Weight of area against length in the similarity.
            neighbours: How many nearest members count for the diversity of one.
        """
        self._weight, self._count = weight, neighbours
        self._forest = Forest(weight)
        self._graphs: dict[int, ReebGraph] = {}
        self._tree = np.zeros(0, np.int64)  # number in the forest, by member
        self._lower = np.zeros((0, 0))  # distance if exact, else a lower bound of it
        self._exact = np.zeros((0, 0), bool)

    def add(self, graphs: Sequence[ReebGraph]) -> list[int]:
        """Add members.

        Returns:
            Their indices; those of removed members are used again.
        """
        self._thin_out()
        places = self._free_places(len(graphs))
        first = len(self._forest)
        self._forest.extend(graphs)
        self._graphs |= dict(zip(places, graphs, strict=True))
        self._tree[places] = first + np.arange(len(graphs))
        members = self._members()
        profiles = self._forest.trees.profiles
        for place in places:
            bounds = 1 - _bounds(profiles, self._tree[place], self._tree[members])
            for one, other in ((place, members), (members, place)):
                self._lower[one, other] = bounds
                self._exact[one, other] = False
        return places

    def remove(self, index: int) -> None:
        """Take a member out of the set."""
        del self._graphs[index]

    def distance(self, one: int, other: int) -> float:
        """The distance of two members."""
        self._compute(one, np.array([other]))
        return float(self._lower[one, other])

    def nearest(self, index: int) -> tuple[Ints, Floats]:
        """The nearest other members, at most as many as asked for, and their distances.

        Sorted by distance, then index.
        """
        others = self._members()
        others = others[others != index]
        count = min(self._count, len(others))
        while count:
            order = np.argpartition(self._lower[index, others], count - 1)[:count]
            found = others[order]
            unknown = found[~self._exact[index, found]]
            if len(unknown) == 0:
                found = found[np.lexsort((found, self._lower[index, found]))]
                return found, self._lower[index, found]
            self._compute(index, unknown)
        return np.zeros(0, np.int64), np.zeros(0)

    def diversity(self, index: int) -> float:
        """Mean distance to the nearest other members; 1 if there is none.

        Source: EGAD, section III-C.
        """
        _, distances = self.nearest(index)
        return float(distances.mean()) if len(distances) else 1.0

    def _members(self) -> Ints:
        return np.array(sorted(self._graphs), dtype=np.int64)

    def _compute(self, index: int, others: Ints) -> None:
        """Replace bounds by distances."""
        others = others[~self._exact[index, others]]
        trees = np.stack([np.full(len(others), self._tree[index]), self._tree[others]], axis=1)
        distances = 1 - similarities(self._forest, trees)
        for one, other in ((index, others), (others, index)):
            self._lower[one, other] = distances
            self._exact[one, other] = True

    def _free_places(self, count: int) -> list[int]:
        """The lowest indices that no member has, with room for them in the matrices."""
        free = [index for index in range(len(self._graphs) + count) if index not in self._graphs]
        needed = max(free[:count], default=-1) + 1
        grow = max(0, needed - len(self._tree))
        if grow:
            grow = max(grow, len(self._tree) // 2)
            self._tree = np.pad(self._tree, (0, grow))
            self._lower = np.pad(self._lower, (0, grow))
            self._exact = np.pad(self._exact, (0, grow))
        return free[:count]

    def _thin_out(self) -> None:
        """Plant the forest anew without the graphs of removed members, once there are many."""
        if len(self._forest) < 2 * len(self._graphs) + SPARE:
            return
        members = self._members()
        self._forest = Forest(self._weight, [self._graphs[index] for index in members])
        self._tree[members] = np.arange(len(members))


def diversities(graphs: Sequence[ReebGraph], weight: float, neighbours: int) -> Floats:
    """The diversity of each of n shapes among the others, (n,)."""
    everyone = Neighbourhood(weight, neighbours)
    return np.array([everyone.diversity(index) for index in everyone.add(graphs)])


@numba.njit(cache=True)
def _bounds(profiles: Floats, one: int, others: Ints) -> Floats:
    """What the similarity of a graph to each of others cannot exceed (see `similarity.bound`)."""
    result = np.zeros(len(others))
    for i, other in enumerate(others):
        for k in range(profiles.shape[1]):
            result[i] += min(profiles[one, k], profiles[other, k])
    return result

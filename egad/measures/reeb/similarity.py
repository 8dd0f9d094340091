"""Similarity of shapes by matching their Reeb graphs: 1 for equal ones, 0 for nothing in common.

Hilaga et al., "Topology Matching for Fully Automatic Similarity Estimation of 3D Shapes", SIGGRAPH
2001. The distance between two shapes is 1 - similarity.
"""

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from egad._util.arrays import Floats, Ints
from egad._util.kernels import kernel
from egad.measures.reeb.forest import Forest, MatchingMemory, Trees, space
from egad.measures.reeb.graph import ReebGraph
from egad.measures.reeb.matching import match

SLACK = 1e-12  # rounding errors of a bound and of a similarity stay below this


def similarity(a: ReebGraph, b: ReebGraph, weight: float) -> float:
    """Similarity of two shapes, 0 to 1, in either order; `UserError` for different ranges."""
    return float(similarities(Forest(weight, [a, b]), np.array([[0, 1]]))[0])


def similarity_matrix(
    graphs: Sequence[ReebGraph],
    weight: float,
    threads: int = 1,
    watch: Callable[[Iterable[Floats]], Iterable[Floats]] = iter,
) -> Floats:
    """Similarities of all pairs of n shapes, (n, n); `watch` passes the rows through."""
    forest, count = Forest(weight, graphs), len(graphs)
    result = np.eye(count)

    def after(one: int) -> Floats:
        others = np.arange(one + 1, count)
        return similarities(forest, np.stack((np.full_like(others, one), others), axis=1))

    with ThreadPoolExecutor(threads) as pool:
        for one, values in enumerate(watch(pool.map(after, range(count)))):
            result[one, one + 1 :] = result[one + 1 :, one] = values
    return result


def similarities(forest: Forest, pairs: Ints) -> Floats:
    """Similarities of (m, 2) pairs of graphs of a forest, (m,)."""
    return np.asarray(_similarities(forest.trees, pairs))


@kernel(nogil=True)
def _similarities(trees: Trees, pairs: Ints) -> Floats:
    result = np.empty(len(pairs))
    if len(pairs) > 0:
        memory = space(trees.starts)
        for i in range(len(pairs)):
            result[i], _ = compare(trees, pairs[i, 0], pairs[i, 1], -np.inf, memory)
    return result


@kernel()
def compare(
    trees: Trees, one: int, other: int, least: float, memory: MatchingMemory
) -> tuple[float, bool]:
    """Similarity of two graphs and True; if it is below `least`, maybe an upper bound and False."""
    if trees.keys[one] == trees.keys[other]:
        return 1.0, True
    if trees.keys[one] > trees.keys[other]:
        one, other = other, one
    starts = (trees.starts[one], trees.starts[other])
    roots = (trees.starts[one + 1] - 1, trees.starts[other + 1] - 1)
    most = level_bounds(trees.profiles, one, other, trees.levels)
    return match(trees.nodes, starts, roots, most, least, memory)


@kernel(fastmath={"reassoc"})
def bound(profiles: Floats, one: int, other: int) -> float:
    """An upper bound of the similarity of two graphs, by totals; its last digits do not matter."""
    total = 0.0
    for k in range(profiles.shape[1]):
        total += min(profiles[one, k], profiles[other, k])
    return total


@kernel(fastmath={"reassoc"})
def level_bounds(profiles: Floats, one: int, other: int, levels: int) -> Floats:
    """Upper bounds of what two graphs share on each level, the finest first: (levels,)."""
    result = np.empty(levels)
    half = profiles.shape[1] // 2
    end = 0
    for level in range(levels):
        first, end = end, end + 2 ** (levels - 1 - level)
        total = 0.0
        for k in range(first, end):
            total += min(profiles[one, k], profiles[other, k])
            total += min(profiles[one, half + k], profiles[other, half + k])
        result[level] = total
    return result

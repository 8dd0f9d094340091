"""Matching of two multiresolutional Reeb graphs, from the coarsest level to the finest.

Hilaga et al., "Topology Matching for Fully Automatic Similarity Estimation of 3D Shapes", SIGGRAPH
2001, section 5, with two differences that agree better with the program that the published values
come from: the neighbors of a node count less, and a node can be matched to a run of nodes.

Children of matched nodes are matched among themselves, separately in each half of the range.
Matches within such a group do not depend on anything outside it, so groups are matched one by one.

Functions are inlined, and no part of an array is bound to a name: counting the references to arrays
would take longer than the matching.
"""

import numpy as np

from egad._util.arrays import Floats
from egad._util.kernels import kernel
from egad.measures.reeb.forest import (
    ADDED,
    CHOSEN,
    END,
    FIRST,
    FREE,
    LINE,
    MATCHED,
    MAX_MATCHED,
    ORDER,
    SECOND,
    SEEN,
    SIDE,
    STATE,
    MatchingMemory,
    Nodes,
)

Pair = tuple[float, float]  # area and length

NEIGHBOR_WEIGHT = 0.1
MAX_RUNS = 64  # runs that one node is compared to at most: a bound that does not depend on time


@kernel()
def match(
    nodes: Nodes,
    starts: tuple[int, int],
    roots: tuple[int, int],
    most: Floats,
    least: float,
    space: MatchingMemory,
) -> tuple[float, bool]:
    """Similarity of two graphs and True, or an upper bound that is below `least` and False.

    It goes level by level, while it can still reach `least`, which must leave room for the last
    digit of the upper bounds `most` of each level, the finest first. Nodes begin at the finest
    level; where matches are equally good, the result can depend on which graph is the first.
    """
    space.ints[STATE, 0] = space.ints[STATE, 1] = 0
    space.ints[STATE, 3], space.ints[STATE, 4] = -starts[0], space.ints.shape[1] // 2 - starts[1]
    space.ints[CHOSEN, 0] = roots[1]
    shared = total = _match(nodes, space, 0, roots[0], 1)
    first = 0
    for left in range(len(most) - 1, 0, -1):
        reach = total
        for level in range(left):
            reach += min(shared, most[level])
        if reach < least:
            return reach, False
        end = space.ints[STATE, 0]
        shared = 0.0
        for i in range(first, end):
            for half in range(2):
                shared += _match_children(nodes, space, i, half)
        total += shared
        first = end
    return min(total, 1.0), True


@kernel(inline="always")
def _match_children(nodes: Nodes, space: MatchingMemory, i: int, half: int) -> float:
    """Match the children of a match in one half of the range; returns what they share."""
    middle = space.ints[SECOND, i]
    first = _children(nodes, space, 0, space.ints[FIRST, i], middle, half)
    second = _children(nodes, space, 1, middle, space.ints[END, i], half)
    if first == 0 or second == 0:
        return 0.0
    if first == 1 and second == 1:
        space.ints[CHOSEN, 0] = space.ints[SIDE + 1, 0]
        return _match(nodes, space, 0, space.ints[SIDE, 0], 1)
    return _match_group(nodes, space, first, second)


@kernel(inline="always")
def _children(
    nodes: Nodes, space: MatchingMemory, side: int, start: int, end: int, half: int
) -> int:
    """List the children of some nodes in one half of the range; returns their number."""
    count = 0
    for i in range(start, end):
        node = space.ints[MATCHED, i]
        low, high = nodes.rows[node, 1], nodes.rows[node, 2]
        if half == 0:
            low, high = nodes.rows[node, 0], low
        for j in range(low, high):
            space.ints[SIDE + side, count] = nodes.links[j]
            count += 1
    return count


@kernel(inline="always")
def _match(nodes: Nodes, space: MatchingMemory, side: int, node: int, count: int) -> float:
    """Match a node of a side to the chosen ones of the other; returns what they share."""
    area = length = 0.0
    end = space.ints[STATE, 1]
    space.ints[FIRST, space.ints[STATE, 0]] = end
    if side == 0:
        space.ints[MATCHED, end] = node
        end += 1
        space.ints[SECOND, space.ints[STATE, 0]] = end
    for i in range(count):
        partner = space.ints[CHOSEN, i]
        area += nodes.values[partner, 0]
        length += nodes.values[partner, 1]
        space.ints[FREE, partner + space.ints[STATE, 4 - side]] = False
        space.ints[MATCHED, end] = partner
        end += 1
    if side == 1:
        space.ints[SECOND, space.ints[STATE, 0]] = end
        space.ints[MATCHED, end] = node
        end += 1
    space.ints[FREE, node + space.ints[STATE, 3 + side]] = False
    space.ints[END, space.ints[STATE, 0]] = space.ints[STATE, 1] = end
    space.ints[STATE, 0] += 1
    common: float = min(area, nodes.values[node, 0]) + min(length, nodes.values[node, 1])
    return common


@kernel(inline="always")
def _match_group(nodes: Nodes, space: MatchingMemory, first: int, second: int) -> float:
    """Match the nodes of two sides, the largest first; returns what they share."""
    for side, count in ((0, first), (1, second)):
        for i in range(count):
            space.ints[FREE, space.ints[SIDE + side, i] + space.ints[STATE, 3 + side]] = True
    _sort(nodes, space, first, second)
    total = 0.0
    for i in range(first + second):
        item = space.ints[ORDER, i]
        side, rivals = (0, second) if item >= 0 else (1, first)
        node = space.ints[SIDE + side, item if item >= 0 else -1 - item]
        if space.ints[FREE, node + space.ints[STATE, 3 + side]]:
            count = _choose(nodes, space, node, 1 - side, rivals)
            if count == 0:
                break
            total += _match(nodes, space, side, node, count)
    for side, count in ((0, first), (1, second)):
        for i in range(count):
            space.ints[FREE, space.ints[SIDE + side, i] + space.ints[STATE, 3 + side]] = False
    return total


@kernel(inline="always")
def _sort(nodes: Nodes, space: MatchingMemory, first: int, second: int) -> None:
    for i in range(first + second):
        item = i if i < first else first - 1 - i
        size = _size(nodes, space, item)
        slot = i
        while slot > 0 and size > _size(nodes, space, space.ints[ORDER, slot - 1]):
            space.ints[ORDER, slot] = space.ints[ORDER, slot - 1]
            slot -= 1
        space.ints[ORDER, slot] = item


@kernel(inline="always")
def _size(nodes: Nodes, space: MatchingMemory, item: int) -> float:
    node = space.ints[SIDE, item] if item >= 0 else space.ints[SIDE + 1, -1 - item]
    size: float = nodes.values[node, 0] + nodes.values[node, 1]
    return size


@kernel(inline="always")
def _choose(nodes: Nodes, space: MatchingMemory, node: int, side: int, count: int) -> int:
    """Find the partners on the other side that cost least; returns how many there are."""
    least, chosen, free = np.inf, 0, 0
    for i in range(count):
        other = space.ints[SIDE + side, i]
        if space.ints[FREE, other + space.ints[STATE, 3 + side]]:
            free += 1
            around = nodes.around
            cost = _cost(
                nodes,
                node,
                (nodes.values[other, 0], nodes.values[other, 1]),
                (around[other, 0], around[other, 1]),
                (around[other, 2], around[other, 3]),
            )
            if cost < least:
                least, chosen = cost, 1
                space.ints[CHOSEN, 0] = other
    return _choose_run(nodes, space, node, side, count, least, chosen) if free > 1 else chosen


@kernel(inline="always")
def _choose_run(
    nodes: Nodes, space: MatchingMemory, node: int, side: int, count: int, least: float, chosen: int
) -> int:
    """Like `_choose`, for runs: free nodes that are consecutive at one common neighbor."""
    left, visit = MAX_RUNS, _tick(space)
    for i in range(count):
        other = space.ints[SIDE + side, i]
        if not space.ints[FREE, other + space.ints[STATE, 3 + side]]:
            continue
        for j in range(nodes.rows[other, 3], nodes.rows[other, 4]):
            neighbor = nodes.links[j]
            if space.ints[SEEN, neighbor + space.ints[STATE, 3 + side]] == visit:
                continue
            space.ints[SEEN, neighbor + space.ints[STATE, 3 + side]] = visit
            length = _line(nodes, space, neighbor, other, side)
            for start in range(length - 1):
                end = min(length, start + MAX_MATCHED, start + 1 + left)
                cost, best = _best_end(nodes, space, node, side, start, end)
                if cost < least:
                    least, chosen = cost, best - start
                    for k in range(chosen):
                        space.ints[CHOSEN, k] = space.ints[LINE, start + k]
                left -= end - start - 1
                if left == 0:
                    return chosen
    return chosen


@kernel(inline="always")
def _tick(space: MatchingMemory) -> int:
    space.ints[STATE, 2] += 1
    visit: int = space.ints[STATE, 2]
    return visit


@kernel(inline="always")
def _line(nodes: Nodes, space: MatchingMemory, neighbor: int, other: int, side: int) -> int:
    """List the free nodes that a neighbor has in the range of another; returns their number."""
    length = 0
    for j in range(nodes.rows[neighbor, 3], nodes.rows[neighbor, 4]):
        node = nodes.links[j]
        same_side = (node < neighbor) == (other < neighbor)
        if same_side and space.ints[FREE, node + space.ints[STATE, 3 + side]]:
            space.ints[LINE, length] = node
            length += 1
    return length


@kernel(inline="always")
def _best_end(
    nodes: Nodes, space: MatchingMemory, node: int, side: int, start: int, end: int
) -> tuple[float, int]:
    """The least cost of matching a node to line[start:e], and that e; start + 2 <= e <= end."""
    visit = _tick(space)
    area = length = area_below = length_below = area_above = length_above = 0.0
    least, best = np.inf, start
    for i in range(start, end):
        other = space.ints[LINE, i]
        area += nodes.values[other, 0]
        length += nodes.values[other, 1]
        for j in range(nodes.rows[other, 3], nodes.rows[other, 4]):
            neighbor = nodes.links[j]
            if space.ints[ADDED, neighbor + space.ints[STATE, 3 + side]] == visit:
                continue
            space.ints[ADDED, neighbor + space.ints[STATE, 3 + side]] = visit
            if neighbor < other:
                area_below += nodes.values[neighbor, 0]
                length_below += nodes.values[neighbor, 1]
            else:
                area_above += nodes.values[neighbor, 0]
                length_above += nodes.values[neighbor, 1]
        if i > start:
            below, above = (area_below, length_below), (area_above, length_above)
            cost = _cost(nodes, node, (area, length), below, above)
            if cost < least:
                least, best = cost, i + 1
    return least, best


@kernel(inline="always")
def _cost(nodes: Nodes, node: int, values: Pair, below: Pair, above: Pair) -> float:
    """Twice what is lost by matching a node to one node, or a run of nodes, with these values."""
    cost: float = abs(nodes.around[node, 0] - below[0]) + abs(nodes.around[node, 1] - below[1])
    cost += abs(nodes.around[node, 2] - above[0])
    cost += abs(nodes.around[node, 3] - above[1])
    cost *= NEIGHBOR_WEIGHT
    cost += abs(nodes.values[node, 0] - values[0])
    cost += abs(nodes.values[node, 1] - values[1])
    return cost

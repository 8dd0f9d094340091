"""From the finest Reeb graph to all the coarser ones: ranges are merged two by two."""

import numba
import numpy as np
from numpy.typing import NDArray

from egad.measures.ranges import Parts, distinct, labels, unite

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]


@numba.njit(cache=True)
def levels(
    parts: Parts, count: int
) -> tuple[Ints, Ints, Floats, Floats, Ints, Ints, Ints, Ints, Ints]:
    """Build `count` levels, each of half as many ranges as the one before.

    A coarser node is a connected union of finer ones, with the sums of their areas and lengths.

    Args:
        parts: The finest level, sorted by range.
        count: Number of levels, the finest included.

    Returns:
        The fields of `egad.measures.reeb.ReebGraph`.
    """
    most = count * len(parts.ranges)
    starts = np.zeros(count + 1, np.int32)
    ranges, parents = np.empty(most, np.int32), np.full(most, -1, np.int32)
    areas, lengths = np.empty(most), np.empty(most)
    links, linked = np.empty((count * len(parts.links), 2), np.int32), 0
    for level in range(count):
        start, end = starts[level], starts[level] + len(parts.ranges)
        starts[level + 1] = end
        ranges[start:end] = parts.ranges
        areas[start:end], lengths[start:end] = parts.areas, parts.lengths
        links[linked : linked + len(parts.links)] = parts.links + start
        linked += len(parts.links)
        if level < count - 1:
            parts, parent = _coarser(parts)
            parents[start:end] = parent + end
    nodes = starts[-1]
    inner = np.arange(starts[-2]).astype(np.int32)
    low, high = links[:linked, 0].copy(), links[:linked, 1].copy()
    child_starts, children = _rows(parents[: starts[-2]], inner, nodes)
    neighbour_starts, neighbours = _rows(
        np.concatenate((high, low)), np.concatenate((low, high)), nodes
    )
    return (
        starts,
        ranges[:nodes].copy(),
        areas[:nodes].copy(),
        lengths[:nodes].copy(),
        parents[:nodes].copy(),
        child_starts,
        children,
        neighbour_starts,
        neighbours,
    )


@numba.njit(cache=True)
def _coarser(parts: Parts) -> tuple[Parts, Ints]:
    """The next level, and which of its nodes each part belongs to."""
    roots = np.arange(len(parts.ranges)).astype(np.int32)
    within = np.empty(len(parts.links), np.bool_)
    for i, (low, high) in enumerate(parts.links):
        within[i] = parts.ranges[low] % 2 == 0
        if within[i]:
            unite(roots, low, high)
    parent, count = labels(roots)
    ranges, areas, lengths = np.empty(count, np.int32), np.zeros(count), np.zeros(count)
    for i, above in enumerate(parent):
        ranges[above] = parts.ranges[i] // 2
        areas[above] += parts.areas[i]
        lengths[above] += parts.lengths[i]
    across = parts.links[~within]
    links = distinct(parent[across[:, 0]], parent[across[:, 1]], count)
    return Parts(ranges, areas, lengths, links), parent


@numba.njit(cache=True)
def _rows(owners: Ints, items: Ints, count: int) -> tuple[Ints, Ints]:
    """Items by their owners, in compressed rows; within a row they keep their order."""
    starts = np.zeros(count + 1, np.int32)
    for owner in owners:
        starts[owner + 1] += 1
    for row in range(count):
        starts[row + 1] += starts[row]
    place, result = starts.copy(), np.empty_like(items)
    for i, owner in enumerate(owners):
        result[place[owner]] = items[i]
        place[owner] += 1
    return starts, result

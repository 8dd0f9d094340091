"""The arrays that Reeb graphs are matched in: the graphs, and memory for the work."""

from typing import NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]

LONGEST_RUN = 5  # of nodes that one node may be matched to


class Nodes(NamedTuple):
    """Nodes of many graphs in one row; in each graph the coarsest one is the last."""

    values: Floats  # (n, 2): weighted area and length
    around: Floats  # (n, 4): their sums over the neighbours below, and above
    rows: Ints  # (n, 5): where in `links` a node's children begin, those in the upper half of its
    # range begin, and all of them end; where its neighbours begin and end
    links: Ints


class Space(NamedTuple):
    """Memory of a matching, to be used again for the next one.

    All integers share one array, as every array of its own would slow each call down.
    """

    ints: Ints  # (_ROWS, 2 n): a row for each purpose below


STATE = 0  # numbers of matches, of their nodes and of visits; what to add to nodes of either graph
FREE = 1  # by node so shifted: whether it may still be matched in this contest
SEEN = 2  # likewise: last visit as a neighbour that runs are taken from
ADDED = 3  # likewise: last visit as a neighbour of a run
MATCHED = 4  # nodes of all matches
FIRST, SECOND, END = 5, 6, 7  # by match: where in MATCHED either side begins, and where it ends
SIDE = 8  # and 9: nodes of a contest
ORDER = 10  # of these by size: index in the first side, or -1 - index in the second
LINE = 11  # nodes that runs are cut from
CHOSEN = 12  # best partners so far
_ROWS = 13


@numba.njit(cache=True)
def space(starts: Ints) -> Space:
    """Memory to match any two of the graphs that start at these nodes, the end of all included."""
    largest = 0
    for i in range(len(starts) - 1):
        largest = max(largest, starts[i + 1] - starts[i])
    return Space(np.zeros((_ROWS, max(2 * largest, LONGEST_RUN)), np.int32))

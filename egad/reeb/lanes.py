"""Distances to many sources, lowered side by side."""

import numpy as np
from numpy.typing import NDArray

from egad._util.kernels import kernel

LANES = 52  # sources of a row: 13 registers of four numbers; most processors have 16


@kernel(fastmath={"nnan", "nsz"})
def lower(
    distances: NDArray[np.float64],
    vertex: int,
    neighbors: NDArray[np.uint32],
    lengths: NDArray[np.float64],
    start: int,
    end: int,
) -> bool:
    """Lower the distances of a vertex to those via some neighbors; returns whether any was lowered.

    Args:
        distances: (n, LANES), contiguous; no NaN.
        vertex: The vertex.
        neighbors: (e,).
        lengths: (e,) of the edges to them.
        start: First of these edges to use.
        end: The one after the last.
    """
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

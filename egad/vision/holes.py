"""Pixels without a depth."""

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

Depth = NDArray[np.float32]


def filled(depth: Depth) -> Depth:
    """A depth image whose missing pixels have the depth of the nearest one that has any.

    Args:
        depth: Metres; not a number where it is missing, but not everywhere.
    """
    gaps = ~np.isfinite(depth)
    if not gaps.any():
        return depth
    nearest = ndimage.distance_transform_edt(gaps, return_distances=False, return_indices=True)
    whole: Depth = depth[tuple(nearest)]
    return whole

"""The grasp that an outline alone suggests, which a network is compared with (ours)."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from egad.vision.learning_set import LearningSet
from egad.vision.rectangles import agrees, half_turn


def across(mask: NDArray[np.bool_]) -> NDArray[np.float64]:
    """The middle of an object, across its narrower side, as wide as the object is there.

    Args:
        mask: (height, width) which pixels see it, at least two.

    Returns:
        (4,) u, v, angle and opening, pixels and radians.
    """
    rows, columns = np.nonzero(mask)
    points = np.stack([columns, -rows])
    axis = np.linalg.eigh(np.cov(points))[1][:, 0]
    u, up = points.mean(axis=1)
    angle = half_turn(np.arctan2(axis[1], axis[0]))
    return np.array([u, -up, angle, np.ptp(axis @ points) + 1], dtype=np.float64)


def right(shards: LearningSet, numbers: Iterable[int]) -> int:
    """In how many images, by their rows of the index, that grasp agrees with a positive one."""
    pairs = ((shards.mask(number), shards.image(number)[1]) for number in numbers)
    return sum(mask.sum() > 1 and agrees(across(mask), truth) for mask, truth in pairs)

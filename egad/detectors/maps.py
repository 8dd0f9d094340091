"""The four maps that GG-CNN answers with, read to find grasps.

Morrison, Corke and Leitner, "Learning robust, real-time, reactive robotic grasping", IJRR 2020.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from egad._util.arrays import Floats

WIDEST = 150.0  # pixels; the width that the network calls 1
SMOOTHING = 2.0  # pixels; of all four maps
MIN_QUALITY = 0.01  # quality; less is no grasp, and no width is read by it
APART = 21  # pixels; the best of a window this wide is proposed
MAX_PEAKS = 10


class Answer(NamedTuple):
    """Maps of a network, (height, width): angles counterclockwise as seen, openings in pixels."""

    quality: Floats
    angle: Floats
    opening: Floats


def prepare_input(depth: NDArray[np.floating], mean: float | None = None) -> NDArray[np.float32]:
    """Depths, metres without gaps, minus their mean (or `mean`), clipped to [-1, 1] metre."""
    middle = depth.mean() if mean is None else mean
    clipped: NDArray[np.float32] = np.clip(depth - middle, -1, 1).astype(np.float32)
    return clipped


def read_maps(maps: NDArray[np.floating]) -> Answer:
    """Smooth four maps (4, height, width), decode angle; divide the width by the quality."""
    quality, cosine, sine, width = (
        ndimage.gaussian_filter(each.astype(np.float64), SMOOTHING) for each in maps
    )
    part = np.clip(width / np.maximum(quality, MIN_QUALITY), 0, 1)
    return Answer(quality, np.arctan2(sine, cosine) / 2, part * WIDEST)


def read_as_published(maps: NDArray[np.floating]) -> Answer:
    """Decode angle and width, then smooth all three, as on the robot of EGAD."""
    quality, cosine, sine, width = maps.astype(np.float64)
    decoded = (quality, np.arctan2(sine, cosine) / 2, width * WIDEST)
    return Answer(*(ndimage.gaussian_filter(each, SMOOTHING) for each in decoded))


def peaks(quality: Floats) -> list[tuple[int, int]]:
    """Rows and columns of the pixels that are the best of all around them, the best first."""
    highest = ndimage.maximum_filter(quality, APART) == quality
    rows, columns = np.nonzero(highest)
    order = np.argsort(-quality[rows, columns], kind="stable")[:MAX_PEAKS]
    return [(int(rows[i]), int(columns[i])) for i in order]


def best(answer: Answer) -> Floats:
    """The grasp at the highest peak, (4,): u, v, angle and opening, pixels and radians."""
    row, column = peaks(answer.quality)[0]
    place = (row, column)
    return np.array([column, row, answer.angle[place], answer.opening[place]], dtype=np.float64)

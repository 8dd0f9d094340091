"""What goes into a network of the kind of GG-CNN, and how the maps that come out are read.

Morrison, Corke and Leitner, "Learning robust, real-time, reactive robotic grasping", IJRR 2020.
Theirs are the size and scaling of what goes in, the code of angle and width, and that peaks of the
smoothed quality are grasps. Ours are how angle and width are smoothed, that the width is divided by
the quality, and which peaks count.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

Floats = NDArray[np.float64]

SIZE = 300  # pixels a side of the image that goes in, and of those that come out
WIDEST = 150.0  # pixels; the width that the network calls 1
SMOOTHING = 2.0  # pixels; of all four maps
LEAST = 0.01  # quality; less is no grasp, and no width is read by it
APART = 21  # pixels; the best of a window this wide is proposed
MOST_PEAKS = 10


class Answer(NamedTuple):
    """The maps of a network, read.

    Attributes:
        quality: Smoothed quality, (height, width).
        angle: Of the closing axis, radians anticlockwise as seen, in [-pi/2, pi/2].
        opening: Pixels.
    """

    quality: Floats
    angle: Floats
    opening: Floats


def prepared(depth: NDArray[np.floating]) -> NDArray[np.float32]:
    """Depths less their mean, clipped to [-1, 1] metre, as the networks are trained on."""
    clipped: NDArray[np.float32] = np.clip(depth - depth.mean(), -1, 1).astype(np.float32)
    return clipped


def read(maps: NDArray[np.floating]) -> Answer:
    """Smooth the four maps (4, height, width) of a network, and decode angle and width.

    A network learns a width of 0 wherever there is no grasp. So where it is half certain it answers
    with half of the width; the quotient by the quality is the width of the grasp, if there is one.
    """
    quality, cosine, sine, width = (
        ndimage.gaussian_filter(each.astype(np.float64), SMOOTHING) for each in maps
    )
    part = np.clip(width / np.maximum(quality, LEAST), 0, 1)
    return Answer(quality, np.arctan2(sine, cosine) / 2, part * WIDEST)


def peaks(quality: Floats) -> list[tuple[int, int]]:
    """Rows and columns of the pixels that are the best of all around them, the best first."""
    highest = ndimage.maximum_filter(quality, APART) == quality
    rows, columns = np.nonzero(highest)
    order = np.argsort(-quality[rows, columns], kind="stable")[:MOST_PEAKS]
    return [(int(rows[i]), int(columns[i])) for i in order]


def best(answer: Answer) -> Floats:
    """The grasp at the highest peak, (4,): u, v, angle and opening, pixels and radians."""
    row, column = peaks(answer.quality)[0]
    place = (row, column)
    return np.array([column, row, answer.angle[place], answer.opening[place]], dtype=np.float64)

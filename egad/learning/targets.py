"""The four maps of GG-CNN: painted from grasp rectangles, and read to find grasps.

Morrison, Corke and Leitner, "Learning robust, real-time, reactive robotic grasping", IJRR 2020.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from egad._util.arrays import Floats
from egad._util.kernels import kernel
from egad.learning.parameters import SIZE
from egad.perception import Rectangles

WIDEST = 150.0  # pixels; the width that the network calls 1
SMOOTHING = 2.0  # pixels; of all four maps
MIN_QUALITY = 0.01  # quality; less is no grasp, and no width is read by it
APART = 21  # pixels; the best of a window this wide is proposed
MAX_PEAKS = 10
MIDDLE = 1 / 3  # of the opening, where the quality is 1


class Answer(NamedTuple):
    """The maps of a network, read.

    Attributes:
        quality: Smoothed quality, (height, width).
        angle: Angle of the closing axis, radians counterclockwise as seen, in [-pi/2, pi/2].
        opening: Pixels.
    """

    quality: Floats
    angle: Floats
    opening: Floats


def prepare_input(depth: NDArray[np.floating], mean: float | None = None) -> NDArray[np.float32]:
    """Depths minus their mean, clipped to [-1, 1] metre, as the networks are trained on.

    Args:
        depth: Metres, without gaps.
        mean: That of the whole image, if these depths are a crop of it.
    """
    middle = depth.mean() if mean is None else mean
    clipped: NDArray[np.float32] = np.clip(depth - middle, -1, 1).astype(np.float32)
    return clipped


def read_maps(maps: NDArray[np.floating]) -> Answer:
    """Smooth the four maps (4, height, width) of a network, and decode angle and width.

    A network learns a width of 0 wherever there is no grasp. So where it predicts a quality of 0.5,
    it also predicts half of the width; divided by the quality, this is the width of the grasp, if
    there is one.
    """
    quality, cosine, sine, width = (
        ndimage.gaussian_filter(each.astype(np.float64), SMOOTHING) for each in maps
    )
    part = np.clip(width / np.maximum(quality, MIN_QUALITY), 0, 1)
    return Answer(quality, np.arctan2(sine, cosine) / 2, part * WIDEST)


def read_as_published(maps: NDArray[np.floating]) -> Answer:
    """Decode angle and width, then smooth all three, as on the robot of EGAD.

    Smoothing mixes angles of -90 and 90 degrees, which are the same, into 0; and where the network
    predicts a quality of 0.5, the width is half of that of the grasp.
    """
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


def targets(rectangles: Rectangles, size: int = SIZE) -> NDArray[np.float32]:
    """Maps of quality, cos 2a, sin 2a and width, (4, size, size).

    The quality is 1 in the middle third along the opening of each rectangle, over its whole
    breadth, and 0 elsewhere. There the other maps hold the angle a and the opening, clipped to 150
    pixels, which count as 1. Where rectangles overlap, the later one counts. Elsewhere they are 0
    (ours: in GG-CNN the angle there is 0, so its cosine 1, which smoothing then mixes into the
    angles at the border).

    Args:
        rectangles: (n, 5), from the least important to the most.
        size: Pixels along each side.
    """
    maps = np.zeros((4, size, size), np.float32)
    _paint(np.ascontiguousarray(rectangles, dtype=np.float64), maps)
    return maps


@kernel(nogil=True)
def _paint(rectangles: Rectangles, maps: NDArray[np.float32]) -> None:
    size = maps.shape[1]
    for u, v, angle, opening, breadth in rectangles:
        cosine, sine = np.cos(angle), np.sin(angle)
        along, aside = opening * MIDDLE / 2, breadth / 2
        reach_u = abs(cosine) * along + abs(sine) * aside
        reach_v = abs(sine) * along + abs(cosine) * aside
        rows = range(max(0, int(np.ceil(v - reach_v))), min(size, int(np.floor(v + reach_v)) + 1))
        columns = range(
            max(0, int(np.ceil(u - reach_u))), min(size, int(np.floor(u + reach_u)) + 1)
        )
        for row in rows:
            for column in columns:
                x, y = column - u, v - row
                if (
                    abs(cosine * x + sine * y) <= along + 1e-9
                    and abs(cosine * y - sine * x) <= aside + 1e-9
                ):
                    maps[0, row, column] = 1
                    maps[1, row, column] = np.cos(2 * angle)
                    maps[2, row, column] = np.sin(2 * angle)
                    maps[3, row, column] = min(max(opening, 0), WIDEST) / WIDEST

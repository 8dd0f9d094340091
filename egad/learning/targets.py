"""The four maps of GG-CNN, painted from grasp rectangles.

Morrison, Corke and Leitner, "Learning robust, real-time, reactive robotic grasping", IJRR 2020.
"""

import numpy as np
from numpy.typing import NDArray

from egad._util.kernels import kernel
from egad.detectors import SIZE
from egad.detectors.maps import WIDEST
from egad.learning.images import Rectangles

MIDDLE = 1 / 3  # of the opening, where the quality is 1


def targets(rectangles: Rectangles, size: int = SIZE) -> NDArray[np.float32]:
    """Maps of quality, cos 2a, sin 2a and width, (4, size, size), of rectangles (n, 5).

    In the middle third along the opening, the quality is 1, and the others hold angle and opening
    (150 pixels count as 1); later rectangles win. Elsewhere all are 0 (GG-CNN: a cosine of 1).
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

"""Changed images that still show possible grasps: quarter turns, and a closer look.

As GG-CNN does: quarter turns, each equally likely, and a zoom that shows the middle of the image.
The depths stay as they are.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from egad.perception import Rectangles, half_turn


class Change(NamedTuple):
    """How an image is changed.

    Attributes:
        turns: Quarter turns, anticlockwise as seen.
        zoom: Part of the image's side that is shown, enlarged to the whole side.
    """

    turns: int = 0
    zoom: float = 1.0


def sample_change(zoom: tuple[float, float], rng: np.random.Generator) -> Change:
    """Draw a change.

    Args:
        zoom: Least and greatest part of the side that is shown.
        rng: Source of chance.
    """
    return Change(int(rng.integers(4)), float(rng.uniform(*zoom)))


def change_depth(depth: NDArray[np.floating], change: Change) -> NDArray[np.floating]:
    """A square depth image without gaps after a change; linear between pixels."""
    turned = np.rot90(depth, change.turns)
    if change.zoom == 1:
        return turned
    low = (len(depth) - 1) / 2 * (1 - change.zoom)
    scale = [change.zoom, change.zoom]
    result: NDArray[np.floating] = ndimage.affine_transform(
        turned, scale, (low, low), order=1, mode="nearest"
    )
    return result


def change_rectangles(rectangles: Rectangles, change: Change, size: int) -> Rectangles:
    """The rectangles (n, 5) after a change of the image, `size` pixels along each side."""
    middle = (size - 1) / 2
    u, v = rectangles[:, 0] - middle, rectangles[:, 1] - middle
    for _ in range(change.turns % 4):
        u, v = v, -u
    return np.column_stack(
        [
            middle + u / change.zoom,
            middle + v / change.zoom,
            half_turn(rectangles[:, 2] + change.turns * np.pi / 2),
            rectangles[:, 3:] / change.zoom,
        ]
    )

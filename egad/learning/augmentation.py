"""Changed images that still show possible grasps: quarter turns, a closer look, and a crop.

As GG-CNN does: quarter turns, each equally likely, and a zoom that shows the middle of the image.
The depths stay as they are. Ours is the crop, a square of the changed image: only its pixels are
computed.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from egad.detectors import SIZE
from egad.learning.images import Rectangles, half_turn

AIMED = 0.75  # fraction of the crops that show a positive grasp, if the image has one


class Change(NamedTuple):
    """Quarter turns, counterclockwise as seen, and the part of an image's side that is shown."""

    turns: int = 0
    zoom: float = 1.0


class Crop(NamedTuple):
    """A square of an image, by its first pixel and its side in pixels."""

    row: int = 0
    column: int = 0
    side: int = SIZE


WHOLE: Crop = Crop()


def sample_change(zoom: tuple[float, float], rng: np.random.Generator) -> Change:
    """Draw a change; `zoom` is the least and the greatest part of the side that is shown."""
    return Change(int(rng.integers(4)), float(rng.uniform(*zoom)))


def sample_crop(rectangles: Rectangles, side: int, rng: np.random.Generator) -> Crop:
    """Draw a square of an image: 3 of 4 contain the center of one of its grasps (ours)."""
    centers = rectangles[(np.abs(rectangles[:, :2] - (SIZE - 1) / 2) < SIZE / 2).all(axis=1), :2]
    low, high = np.zeros(2, int), np.full(2, SIZE - side)
    if rng.random() < AIMED and len(centers):
        pixel = np.round(centers[rng.integers(len(centers)), ::-1]).astype(int)
        low, high = np.maximum(low, pixel - side + 1), np.minimum(high, pixel)
    row, column = rng.integers(low, high + 1)
    return Crop(int(row), int(column), side)


def change_depth(
    depth: NDArray[np.floating], change: Change, crop: Crop = WHOLE
) -> NDArray[np.floating]:
    """A crop of a square depth image without gaps after a change; linear between pixels."""
    turned = np.rot90(depth, change.turns)
    row, column, side = crop
    if change.zoom == 1:
        return turned[row : row + side, column : column + side]
    first = _source_rows(len(depth), change.zoom)[[row, column]]
    scale = [change.zoom, change.zoom]
    result: NDArray[np.floating] = ndimage.affine_transform(
        turned, scale, first, (side, side), order=1, mode="nearest"
    )
    return result


def mean_depth(depth: NDArray[np.floating], change: Change) -> float:
    """The mean of the whole image after a change, without computing its pixels."""
    size = len(depth)
    rows = _source_rows(size, change.zoom)
    first = np.minimum(rows.astype(int), size - 2)
    part = rows - first
    weights = np.bincount(first, 1 - part, size) + np.bincount(first + 1, part, size)
    return float(weights @ depth @ weights) / size**2  # the same for every turn: they are symmetric


def _source_rows(size: int, zoom: float) -> NDArray[np.float64]:
    """Rows of an image that become the rows of the zoomed image."""
    middle = (size - 1) / 2
    return middle + zoom * (np.arange(size, dtype=np.float64) - middle)


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


def crop_rectangles(rectangles: Rectangles, crop: Crop) -> Rectangles:
    """The rectangles (n, 5) of an image in a crop of it; they may lie outside."""
    return rectangles - [crop.column, crop.row, 0, 0, 0]

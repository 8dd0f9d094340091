"""Picture files of image sets: depths as TIFF, masks as PNG."""

import logging
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from egad.learning.images import SPLITS, ImageGrasps, RenderedImage

log = logging.getLogger(__name__)
NOTHING = 0.0  # what readers of these sets take for a missing depth


def write_by_split(
    pictures: Iterable[RenderedImage], folder: Path, write: Callable[[RenderedImage, Path], bool]
) -> int:
    """Write images, one folder per split, and return how many `write` says it has written."""
    for split in SPLITS:
        (folder / split).mkdir()
    written = [write(picture, folder / picture.split) for picture in pictures]
    log.info("%d of %d images", sum(written), len(written))
    return sum(written)


def write_depth(depth: NDArray[np.float32], path: Path) -> None:
    """Write metres as a compressed TIFF file of 32-bit floats; 0 where it is missing."""
    known = np.where(np.isfinite(depth), depth, np.float32(NOTHING))
    Image.fromarray(known).save(path, "tiff", compression="tiff_adobe_deflate")


def write_mask(mask: NDArray[np.bool_], path: Path) -> None:
    """Write a mask as a PNG file: 255 where it is set, else 0."""
    Image.fromarray(np.where(mask, np.uint8(255), np.uint8(0))).save(path, "png")


def corners(grasps: ImageGrasps, breadth: NDArray[np.float64]) -> NDArray[np.float64]:
    """Corners of n rectangles, (n, 4, 2) u and v, along the opening first; jaw (n,) pixels."""
    ends = grasps.ends()
    across = np.stack([np.sin(grasps.angle), np.cos(grasps.angle)], axis=1)
    aside = across[:, None] * breadth[:, None, None] / 2
    low, high = ends - aside, ends + aside
    return np.stack([low[:, 0], low[:, 1], high[:, 1], high[:, 0]], axis=1)

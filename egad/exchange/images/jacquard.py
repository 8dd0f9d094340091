"""Image sets laid out as Jacquard: a folder per object, with the grasps in files beside the images.

Depierre, Dellandréa and Chen, "Jacquard: a large scale dataset for robotic grasp detection", 2018.
"""

import logging
from collections.abc import Iterable
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from egad.errors import UserError
from egad.grippers import Gripper
from egad.learning.images import SPLITS, RenderedImage

Kind = TypeVar("Kind", np.float32, np.bool_)
SIDE = 1024  # pixels of the images, which readers rely on
NOTHING = 0.0  # what readers take for a missing depth

log = logging.getLogger(__name__)


def write(pictures: Iterable[RenderedImage], gripper: Gripper, folder: Path) -> int:
    """Write a set of images, a folder for each split, and return how many."""
    for split in SPLITS:
        (folder / split).mkdir()
    count = 0
    for picture in pictures:
        write_image(picture, folder / picture.split, gripper)
        count += 1
    log.info("%d images", count)
    return count


def write_image(picture: RenderedImage, folder: Path, gripper: Gripper) -> None:
    """Write `I_LABEL_perfect_depth.tiff`, `I_LABEL_mask.png` and the free `I_LABEL_grasps.txt`."""
    height, width = picture.depth.shape
    if height != width:
        raise UserError(f"Jacquard images are square, these have {width} x {height} pixels")
    place = folder / picture.label
    place.mkdir(parents=True, exist_ok=True)
    name = f"{picture.image}_{picture.label}"
    scale = SIDE / width
    depth = _enlarged(np.where(np.isfinite(picture.depth), picture.depth, np.float32(NOTHING)))
    tiff = Image.fromarray(depth)
    tiff.save(place / f"{name}_perfect_depth.tiff", "tiff", compression="tiff_adobe_deflate")
    mask = np.where(_enlarged(picture.mask > 0), np.uint8(255), np.uint8(0))
    Image.fromarray(mask).save(place / f"{name}_mask.png", "png")
    grasps = picture.grasps.chosen(picture.grasps.collision_free)
    breadth = gripper.finger_width * picture.view.intrinsics.focal / grasps.depth_center
    columns = [
        (grasps.u + 0.5) * scale - 0.5,
        (grasps.v + 0.5) * scale - 0.5,
        -np.degrees(grasps.angle),
        grasps.opening * scale,
        breadth * scale,
    ]
    lines = [";".join(f"{value:.6g}" for value in row) for row in np.transpose(columns)]
    (place / f"{name}_grasps.txt").write_text("".join(f"{line}\n" for line in lines))


def _enlarged(pixels: NDArray[Kind]) -> NDArray[Kind]:
    nearest = ((np.arange(SIDE) + 0.5) * len(pixels) / SIDE).astype(int)
    enlarged: NDArray[Kind] = pixels[np.ix_(nearest, nearest)]
    return enlarged

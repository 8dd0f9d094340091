"""Image sets laid out as Jacquard: a folder per object, with the grasps in files beside the images.

Depierre, Dellandréa and Chen, "Jacquard: a large scale dataset for robotic grasp detection", 2018.
"""

from collections.abc import Iterable
from functools import partial
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from egad.errors import UserError
from egad.exchange.pictures import write_by_split, write_depth, write_mask
from egad.grippers import Gripper
from egad.learning.images import RenderedImage

Kind = TypeVar("Kind", np.float32, np.bool_)
SIDE = 1024  # pixels of the images, which readers rely on


def write(pictures: Iterable[RenderedImage], gripper: Gripper, folder: Path) -> int:
    """Write a set of images, a folder for each split."""
    return write_by_split(pictures, folder, partial(write_image, gripper=gripper))


def write_image(picture: RenderedImage, folder: Path, gripper: Gripper) -> bool:
    """Write `I_LABEL_perfect_depth.tiff`, `I_LABEL_mask.png` and the free `I_LABEL_grasps.txt`."""
    height, width = picture.depth.shape
    if height != width:
        raise UserError(f"Jacquard images are square, these have {width} x {height} pixels")
    place = folder / picture.label
    place.mkdir(parents=True, exist_ok=True)
    name = f"{picture.image}_{picture.label}"
    scale = SIDE / width
    write_depth(_enlarged(picture.depth), place / f"{name}_perfect_depth.tiff")
    write_mask(_enlarged(picture.mask > 0), place / f"{name}_mask.png")
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
    return True


def _enlarged(pixels: NDArray[Kind]) -> NDArray[Kind]:
    nearest = ((np.arange(SIDE) + 0.5) * len(pixels) / SIDE).astype(int)
    enlarged: NDArray[Kind] = pixels[np.ix_(nearest, nearest)]
    return enlarged

"""Image sets laid out as the Cornell grasping dataset: depth images with rectangles in text files.

Lenz, Lee and Saxena, "Deep learning for detecting robotic grasps", IJRR 2015.
"""

from collections.abc import Iterable
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from egad.detectors import table_depth
from egad.errors import UserError
from egad.exchange.pictures import corners, write_by_split, write_depth
from egad.grippers import Gripper
from egad.learning.images import ImageGrasps, RenderedImage

WIDTH, HEIGHT = 640, 480  # pixels of the images, which readers rely on


def write(pictures: Iterable[RenderedImage], gripper: Gripper, folder: Path) -> int:
    """Write a set of images, a folder for each split."""
    return write_by_split(pictures, folder, partial(write_image, gripper=gripper))


def write_image(picture: RenderedImage, folder: Path, gripper: Gripper) -> bool:
    """Write `pcdNNNNd.tiff`, `pcdNNNNcpos.txt` and `pcdNNNNcneg.txt`; false without a free grasp.

    A smaller image is placed in the middle of 640 x 480 pixels, a larger one raises UserError.
    """
    height, width = picture.depth.shape
    if height > HEIGHT or width > WIDTH:
        raise UserError(
            f"Cornell images have {WIDTH} x {HEIGHT} pixels, these have {width} x {height}"
        )
    if not picture.grasps.collision_free.any():
        return False
    place = folder / picture.label
    place.mkdir(parents=True, exist_ok=True)
    left, top = (WIDTH - width) // 2, (HEIGHT - height) // 2
    name = f"pcd{picture.image:04d}"
    write_depth(_surrounded(picture, left, top), place / f"{name}d.tiff")
    grasps = picture.grasps
    moved = grasps._replace(u=grasps.u + left, v=grasps.v + top)
    breadth = gripper.finger_width * picture.view.intrinsics.focal / grasps.depth_center
    for ending, which in (("cpos", grasps.collision_free), ("cneg", ~grasps.collision_free)):
        text = _lines(moved.chosen(which), breadth[which])
        (place / f"{name}{ending}.txt").write_text(text)
    return True


def _surrounded(picture: RenderedImage, left: int, top: int) -> NDArray[np.float32]:
    camera = picture.view.intrinsics
    center = (camera.center[0] + left, camera.center[1] + top)
    whole = camera._replace(width=WIDTH, height=HEIGHT, center=center)
    depth = np.round(table_depth(whole, picture.view.pose), 4)  # steps as inside, to compress well
    depth[top : top + camera.height, left : left + camera.width] = picture.depth
    return depth


def _lines(grasps: ImageGrasps, breadth: NDArray[np.float64]) -> str:
    points = corners(grasps, breadth).reshape(-1, 2)
    return "".join(f"{u:.3f} {v:.3f}\n" for u, v in points)

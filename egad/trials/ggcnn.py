"""ggcnn: grasps from the networks of GG-CNN, for every pixel of a depth image.

Morrison, Corke and Leitner, "Learning robust, real-time, reactive robotic grasping", IJRR 2020.
Theirs are the networks, the size and scaling of what goes in, the code of angle and width, and that
peaks of the smoothed quality are grasps. Ours are how gaps are filled, how angle and width are
smoothed, which peaks count, and how deep the hand reaches.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from egad.errors import UserError
from egad.grasps.room import TABLE_CLEARANCE
from egad.settings import Gripper
from egad.trials.files import GGCNN_WEIGHTS, check_ggcnn
from egad.trials.grasp import Grasp
from egad.vision.camera import View
from egad.vision.holes import filled

Floats = NDArray[np.float64]

SIZE = 300  # pixels a side of the image that goes in, and of those that come out
WIDEST = 150.0  # pixels; the width that the network calls 1
SMOOTHING = 2.0  # pixels; of all four images
APART = 21  # pixels; the best of a window this wide is proposed
MOST_PEAKS = 10
BITE = 0.02  # the fingertips go this far below the surface seen at the centre of the grasp


class Crop(NamedTuple):
    """The middle of a depth image, as the network gets it.

    Attributes:
        depth: (300, 300) metres, without gaps.
        corner: Row and column of its first pixel in the image.
        scale: Pixels of the image that one of its pixels spans.
    """

    depth: Floats
    corner: tuple[int, int]
    scale: float


class GGCNN:
    """GG-CNN or GG-CNN2, as the weights are."""

    def __init__(self, weights: str | None) -> None:
        """Load a network.

        Args:
            weights: File of its published weights.

        Raises:
            UserError: PyTorch is missing, or the weights are, or they are of another network.
        """
        try:
            from egad.trials.networks import load  # noqa: PLC0415 (an extra)
        except ModuleNotFoundError as error:
            raise UserError(
                "ggcnn needs PyTorch: install egad with its extra, egad[ggcnn]"
            ) from error
        try:
            self._network = load(check_ggcnn(weights))
        except ValueError as error:
            raise UserError(f"{error}; {GGCNN_WEIGHTS}") from error

    def __call__(self, view: View, gripper: Gripper, _rng: np.random.Generator) -> list[Grasp]:
        """Grasps at the peaks of the quality, at most 10 (partly ours, see the top of the file).

        The middle 300 x 300 pixels go in, a smaller image enlarged; pixels without depth get that
        of the nearest one with it. The four images that come out are smoothed. The hand opens as
        wide as the network says or as it can; its fingertips go 20 mm below the surface seen at
        the centre, but not onto the table.
        """
        if not np.isfinite(view.depth).any():
            return []
        crop = middle(view.depth)
        quality, cosine, sine, width = (
            ndimage.gaussian_filter(image.astype(np.float64), SMOOTHING)
            for image in self._network(prepared(crop.depth))
        )
        angle = np.arctan2(sine, cosine) / 2
        return [
            _grasp(
                place,
                crop,
                view,
                gripper,
                *(float(each[place]) for each in (angle, width, quality)),
            )
            for place in _peaks(quality)
        ]


def middle(depth: NDArray[np.float32]) -> Crop:
    """The middle of a depth image, gaps filled with the depth of the nearest pixel that has one."""
    side = min(SIZE, *depth.shape)
    top, left = ((size - side) // 2 for size in depth.shape)
    cut = filled(depth)[top : top + side, left : left + side].astype(np.float64)
    if side < SIZE:
        cut = ndimage.zoom(cut, SIZE / side, order=1, mode="nearest", grid_mode=True)
    return Crop(cut, (top, left), side / SIZE)


def prepared(depth: Floats) -> NDArray[np.float32]:
    """Depths less their mean, clipped to [-1, 1] metre, as the networks were trained on."""
    clipped: NDArray[np.float32] = np.clip(depth - depth.mean(), -1, 1).astype(np.float32)
    return clipped


def _peaks(quality: Floats) -> list[tuple[int, int]]:
    """Places that are the best of all around them, the best first."""
    highest = ndimage.maximum_filter(quality, APART) == quality
    rows, columns = np.nonzero(highest)
    order = np.argsort(-quality[rows, columns], kind="stable")[:MOST_PEAKS]
    return [(int(rows[i]), int(columns[i])) for i in order]


def _grasp(
    place: tuple[int, int],
    crop: Crop,
    view: View,
    gripper: Gripper,
    angle: float,
    width: float,
    quality: float,
) -> Grasp:
    """A grasp of the image, anticlockwise from its rows, as one of the world."""
    camera, depth = view.intrinsics, float(crop.depth[place])
    row, column = (
        (i + 0.5) * crop.scale - 0.5 + low for i, low in zip(place, crop.corner, strict=True)
    )
    u, v = column - camera.center[0], row - camera.center[1]
    seen = depth * np.array([u / camera.focal, v / camera.focal, 1.0])
    x, y, top = (float(part) for part in view.pose[:3, :3] @ seen + view.pose[:3, 3])
    along = view.pose[:3, :3] @ np.array([np.cos(angle), -np.sin(angle), 0.0])
    tip = max(top - BITE, TABLE_CLEARANCE)
    level = max((top + tip) / 2, tip)
    opening = width * WIDEST * crop.scale * depth / camera.focal
    return Grasp(
        center=(x, y, level),
        angle=float(np.arctan2(along[1], along[0])),
        width=float(np.clip(opening, 0.0, gripper.opening)),
        depth=level - tip,
        quality=quality,
    )

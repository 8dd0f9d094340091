"""ggcnn: grasps from the networks of GG-CNN, for every pixel of a depth image.

Morrison, Corke and Leitner, "Learning robust, real-time, reactive robotic grasping", IJRR 2020.
`egad.learning.targets` says what is theirs; how deep the hand reaches is ours.
"""

import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from egad.detectors.base import WHERE, Grasp
from egad.errors import UserError
from egad.grasps import TABLE_CLEARANCE
from egad.grippers import Gripper
from egad.learning import SIZE, peaks, prepare_input, read_maps
from egad.perception import View, fill_missing

MOST_BYTES = 1 << 24  # some 50 times those that were published
GGCNN_WEIGHTS = (
    "`egad train` makes weights; the published ones are in the releases of the project "
    "dougsm/ggcnn, as files named "
    "ggcnn_epoch_23_cornell_statedict.pt (GG-CNN) and epoch_50_cornell_statedict.pt (GG-CNN2)"
)
Floats = NDArray[np.float64]
Infer = Callable[[NDArray[np.float32]], NDArray[np.float32]]
BITE = 0.02  # the fingertips go this far below the surface seen at the center of the grasp


def check_ggcnn(weights: str | None) -> str:
    """The path of GG-CNN's weights, if they are there.

    Raises:
        UserError: None are named, there is no such file, or it is far too large; the text says
            where to get them.
    """
    if weights is None:
        raise UserError(f"{WHERE}: ggcnn needs `weights: FILE`; {GGCNN_WEIGHTS}")
    if not Path(weights).is_file():
        raise UserError(f"{WHERE}: no such file: {weights}; {GGCNN_WEIGHTS}")
    if _size(Path(weights)) > MOST_BYTES:
        raise UserError(f"{WHERE}: {weights} is too large for weights of GG-CNN; {GGCNN_WEIGHTS}")
    return weights


def _size(path: Path) -> int:
    """Bytes of a file, or of all that is in it if it is a zip, as those of PyTorch are."""
    size = path.stat().st_size
    if size > MOST_BYTES or not zipfile.is_zipfile(path):
        return size
    try:
        with zipfile.ZipFile(path) as archive:
            return sum(entry.file_size for entry in archive.infolist())
    except (zipfile.BadZipFile, OSError, ValueError, NotImplementedError):
        return size


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


class MapDetector:
    """Any network that gives the four maps of GG-CNN, as a grasp detector."""

    def __init__(self, infer: Infer) -> None:
        """Take a network.

        Args:
            infer: From depths (300, 300) of `targets.prepare_input` to quality, cos 2a,
                sin 2a and width (4, 300, 300).
        """
        self._infer = infer

    def __call__(self, view: View, gripper: Gripper, _rng: np.random.Generator) -> list[Grasp]:
        """Grasps at the peaks of the quality, at most 10 (see `egad.learning.targets`).

        The middle 300 x 300 pixels go in, a smaller image enlarged; pixels without depth get that
        of the nearest one with it. The four images that come out are smoothed. The hand opens as
        wide as the network says or as it can; its fingertips go 20 mm below the surface seen at
        the center, but not onto the table. Half way between the two are the contacts.
        """
        if not np.isfinite(view.depth).any():
            return []
        crop = middle(view.depth)
        answer = read_maps(self._infer(prepare_input(crop.depth)))
        return [
            _grasp(place, crop, view, gripper, *(float(each[place]) for each in answer))
            for place in peaks(answer.quality)
        ]


class GGCNN(MapDetector):
    """GG-CNN or GG-CNN2, as the weights are."""

    def __init__(self, weights: str | None) -> None:
        """Load a network.

        Args:
            weights: File of weights: safetensors as `egad train` writes them, or published ones.

        Raises:
            UserError: PyTorch is missing, or the weights are, or they are of another network.
        """
        self._weights = path = check_ggcnn(weights)
        try:
            from egad.learning import networks  # noqa: PLC0415 (an extra)
            from egad.learning import weights as files  # noqa: PLC0415
        except ModuleNotFoundError as error:
            raise UserError("ggcnn needs PyTorch: pip install 'egad[vision]'") from error
        try:
            super().__init__(networks.inference(files.read(path)))
        except files.WeightsError as error:
            raise UserError(f"{error}; {GGCNN_WEIGHTS}") from error

    def __reduce__(self) -> tuple[type["GGCNN"], tuple[str]]:
        """For other processes, which load it again."""
        return GGCNN, (str(self._weights),)


def middle(depth: NDArray[np.float32]) -> Crop:
    """The middle of a depth image, gaps filled (`egad.perception.fill_missing`)."""
    side = min(SIZE, *depth.shape)
    top, left = ((size - side) // 2 for size in depth.shape)
    cut = fill_missing(depth)[top : top + side, left : left + side].astype(np.float64)
    if side < SIZE:
        cut = ndimage.zoom(cut, SIZE / side, order=1, mode="nearest", grid_mode=True)
    return Crop(cut, (top, left), side / SIZE)


def _grasp(
    place: tuple[int, int],
    crop: Crop,
    view: View,
    gripper: Gripper,
    quality: float,
    angle: float,
    opening: float,
) -> Grasp:
    """A grasp of the image, anticlockwise from its rows, as one of the world."""
    camera, depth = view.intrinsics, float(crop.depth[place])
    row, column = (
        (i + 0.5) * crop.scale - 0.5 + low for i, low in zip(place, crop.corner, strict=True)
    )
    u, v = column - camera.center[0], row - camera.center[1]
    ray, eye = view.pose[:3, :3] @ np.array([u, v, camera.focal]) / camera.focal, view.pose[:3, 3]
    top = float(eye[2] + depth * ray[2])
    tip = max(top - BITE, TABLE_CLEARANCE)
    level = max((top + tip) / 2, tip)
    # The contacts are seen through the surface above them, on the same ray.
    deep = depth + (level - top) / ray[2] if ray[2] < 0 else depth
    x, y = (float(part) for part in (eye + deep * ray)[:2])
    along = view.pose[:3, :3] @ np.array([np.cos(angle), -np.sin(angle), 0.0])
    width = opening * crop.scale * deep / camera.focal
    return Grasp(
        center=(x, y, level),
        angle=float(np.arctan2(along[1], along[0])),
        width=float(np.clip(width, 0.0, gripper.opening)),
        depth=level - tip,
        quality=quality,
    )

"""ggcnn: grasps from the networks of GG-CNN, for every pixel of a depth image.

Morrison, Corke and Leitner, "Learning robust, real-time, reactive robotic grasping", IJRR 2020.
`egad.detectors.maps` describes what is theirs; how deep the hand reaches is ours.
"""

import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from egad._util.arrays import Floats, Ints
from egad._util.extras import needed_for
from egad.detectors.base import FULL_DEPTH, MIN_DEPTH, WHERE, Grasp, depth_weight, rank_grasps
from egad.detectors.camera import View
from egad.detectors.heightmap import Heightmap, heightmap_of, min_fingertip_height
from egad.detectors.maps import Answer, peaks, prepare_input, read_as_published, read_maps
from egad.detectors.parameters import SIZE, Execution
from egad.detectors.restoration import fill_missing, restore
from egad.errors import UserError
from egad.grasps import TABLE_CLEARANCE
from egad.grippers import Gripper

MAX_BYTES = 1 << 24  # about 50 times the size of the published ones
GGCNN_WEIGHTS = (
    "`egad train` makes weights; the published ones are in the releases of the project "
    "dougsm/ggcnn, as files named "
    "ggcnn_epoch_23_cornell_statedict.pt (GG-CNN) and epoch_50_cornell_statedict.pt (GG-CNN2)"
)
SHALLOW, MIN_TIP = 0.01, 0.005  # metres below the surface, and above the table
Infer = Callable[[NDArray[np.float32]], NDArray[np.float32]]


def check_ggcnn(weights: str | None) -> str:
    """The path of GG-CNN's weights; UserError if there is none, or the file is far too large."""
    if weights is None:
        raise UserError(f"{WHERE}: ggcnn needs `weights: FILE`; {GGCNN_WEIGHTS}")
    if not Path(weights).is_file():
        raise UserError(f"{WHERE}: no such file: {weights}; {GGCNN_WEIGHTS}")
    if _size(Path(weights)) > MAX_BYTES:
        raise UserError(f"{WHERE}: {weights} is too large for weights of GG-CNN; {GGCNN_WEIGHTS}")
    return weights


def _size(path: Path) -> int:
    """Bytes of a file, or of all that is in it if it is a zip, as those of PyTorch are."""
    size = path.stat().st_size
    if size > MAX_BYTES or not zipfile.is_zipfile(path):
        return size
    try:
        with zipfile.ZipFile(path) as archive:
            return sum(entry.file_size for entry in archive.infolist())
    except (zipfile.BadZipFile, OSError, ValueError, NotImplementedError):
        return size


class NetworkInput(NamedTuple):
    """The middle of a depth image, (300, 300) m, its corner (pixels), `scale` pixels per pixel."""

    depth: Floats
    corner: tuple[int, int]
    scale: float


class _Spots(NamedTuple):
    """Pixels of the network, each as a grasp from above."""

    row: Ints  # (n,) in the maps of the network
    column: Ints
    top: Floats  # (n,) height of the surface seen, metres
    middle: Floats  # (n, 2) where the contacts should be, world frame, metres
    axis: Floats  # (n, 2) unit vectors of the closing axis
    width: Floats  # (n,) how far the hand opens, metres
    quality: Floats  # (n,) that of the network


class MapDetector:
    """Any network that gives the four maps of GG-CNN, as a grasp detector."""

    def __init__(self, infer: Infer, execution: Execution = "deepest") -> None:
        """Take a network: depths (300, 300) of `maps.prepare_input` to maps (4, 300, 300)."""
        self._infer = infer
        self._execution = execution

    def __call__(self, view: View, gripper: Gripper, _rng: np.random.Generator) -> list[Grasp]:
        """Grasps where the quality is highest and the hand gets deep enough, at most 10.

        With the execution `published` there is one grasp, carried out as on the robot of EGAD (open
        loop, in Morrison's repository mvp_grasp). At the pixel of the highest quality, however low
        that is, the fingertips go 10 mm below the surface that the pixel sees, but not nearer to
        the table than 5 mm, and the hand opens as wide as the network says. What follows describes
        our own execution.

        The input is the middle 300 x 300 pixels; a smaller image is enlarged, and pixels without
        depth are filled. The four output images are smoothed (see `egad.detectors.maps`).

        As in `antipodal-depth`, the hand goes as deep as table, neighboring surface and palm allow
        (`min_fingertip_height`) at a pixel where the network sees a grasp. The
        penetration is how far the fingertips get below the surface seen there. Below 5 mm there is
        no grasp; otherwise its quality is that of the network times min(penetration / 20 mm, 1).
        A pixel is proposed if it is the best of the 21 x 21 pixels around it.

        The hand opens as wide as the network says or as it can. It is placed where the ray of the
        pixel is 10 mm below the surface, or half way down to the table if that is less. There its
        contacts are 10 mm below the surface, or half as deep as the fingertips get. Surfaces and
        heights are those of the image without holes and noise (`egad.detectors.restore`); the
        network sees the noise.
        """
        if not np.isfinite(view.depth).any():
            return []
        maps = self._infer(prepare_input(middle(view.depth).depth))
        if self._execution == "published":
            return [_shallow(maps, view, gripper)]
        answer = read_maps(maps)
        whole = restore(view)
        heightmap = heightmap_of(whole)
        if heightmap is None:
            return []
        return _grasps(_spots(answer, whole, gripper), heightmap, gripper)


class GGCNN(MapDetector):
    """GG-CNN or GG-CNN2, depending on the weights."""

    def __init__(self, weights: str | None, execution: Execution = "deepest") -> None:
        """Load weights: safetensors as `egad train` writes them, or published ones.

        UserError without PyTorch or fitting weights.
        """
        self._weights = path = check_ggcnn(weights)
        with needed_for("GG-CNN"):
            from egad.detectors import networks  # noqa: PLC0415 (an extra)
            from egad.detectors import weights as files  # noqa: PLC0415
        try:
            super().__init__(networks.inference(files.read(path)), execution)
        except files.WeightsError as error:
            raise UserError(f"{error}; {GGCNN_WEIGHTS}") from error

    def __reduce__(self) -> tuple[type["GGCNN"], tuple[str, Execution]]:
        return GGCNN, (str(self._weights), self._execution)


def middle(depth: NDArray[np.float32]) -> NetworkInput:
    """The middle of a depth image, gaps filled (`egad.detectors.fill_missing`)."""
    side = min(SIZE, *depth.shape)
    top, left = ((size - side) // 2 for size in depth.shape)
    cut = fill_missing(depth)[top : top + side, left : left + side].astype(np.float64)
    if side < SIZE:
        cut = ndimage.zoom(cut, SIZE / side, order=1, mode="nearest", grid_mode=True)
    return NetworkInput(cut, (top, left), side / SIZE)


def _shallow(maps: NDArray[np.floating], view: View, gripper: Gripper) -> Grasp:
    """The best pixel as the robot of EGAD carried it out; see `MapDetector.__call__`."""
    crop, answer = middle(view.depth), read_as_published(maps)
    row, column = np.unravel_index(np.argmax(answer.quality), answer.quality.shape)
    place = int(row), int(column)
    depth = crop.depth[place]
    ray = _rays(np.array([place[0]]), np.array([place[1]]), crop, view)[0]
    x, y, top = view.pose[:3, 3] + depth * ray
    tip = max(top - SHALLOW, MIN_TIP)
    level = (max(top, tip) + tip) / 2
    angle = answer.angle[place]
    axis = np.array([np.cos(angle), -np.sin(angle)]) @ view.pose[:2, :2].T
    width = answer.opening[place] * crop.scale * depth / view.intrinsics.focal
    turn = float(np.arctan2(axis[1], axis[0]))
    quality = float(answer.quality[place])
    width = float(np.clip(width, 0, gripper.opening))
    return Grasp((float(x), float(y), float(level)), turn, width, float(level - tip), quality)


def _spots(answer: Answer, view: View, gripper: Gripper) -> _Spots:
    """The pixels with a positive quality whose surface is high enough for the least penetration."""
    crop = middle(view.depth)
    row, column = (each.ravel() for each in np.indices((SIZE, SIZE)))
    rays = _rays(row, column, crop, view)
    depth = crop.depth[row, column]
    top = view.pose[2, 3] + depth * rays[:, 2]
    hopeful = (top >= TABLE_CLEARANCE + MIN_DEPTH) & (answer.quality.ravel() > 0)
    seen = np.flatnonzero(hopeful & (rays[:, 2] < 0))
    row, column = row[seen], column[seen]
    rays, depth, top = rays[seen], depth[seen], top[seen]
    level = (top + np.maximum(top - FULL_DEPTH, TABLE_CLEARANCE)) / 2
    deep = depth + (level - top) / rays[:, 2]
    angle, opening = answer.angle[row, column], answer.opening[row, column]
    width = opening * crop.scale * deep / view.intrinsics.focal
    return _Spots(
        row=row,
        column=column,
        top=top,
        middle=view.pose[:2, 3] + deep[:, None] * rays[:, :2],
        axis=_unit(np.column_stack([np.cos(angle), -np.sin(angle)]) @ view.pose[:2, :2].T),
        width=np.minimum(width, gripper.opening),
        quality=answer.quality[row, column],
    )


def _rays(row: Ints, column: Ints, crop: NetworkInput, view: View) -> Floats:
    """Viewing rays of pixels of the network, one metre of depth long, world frame, (n, 3)."""
    camera = view.intrinsics
    v, u = (
        (each + 0.5) * crop.scale - 0.5 + low - center
        for each, low, center in zip((row, column), crop.corner, camera.center[::-1], strict=True)
    )
    sights = np.column_stack([u, v, np.full(len(u), camera.focal)]) / camera.focal
    rays: Floats = sights @ view.pose[:3, :3].T
    return rays


def _unit(vectors: Floats) -> Floats:
    unit: Floats = vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-12)
    return unit


def _grasps(spots: _Spots, heightmap: Heightmap, gripper: Gripper) -> list[Grasp]:
    """The best spots of all around them that the hand can reach; see `MapDetector.__call__`."""
    tip = min_fingertip_height(spots.middle, spots.axis, spots.width, heightmap, gripper)
    penetration = spots.top - tip
    quality = np.where(penetration >= MIN_DEPTH, spots.quality * depth_weight(penetration), 0.0)
    worth = np.zeros((SIZE, SIZE))
    worth[spots.row, spots.column] = quality
    best = np.zeros((SIZE, SIZE), dtype=bool)
    best[tuple(np.transpose(peaks(worth)))] = True
    chosen = best[spots.row, spots.column] & (quality > 0)
    level = spots.top - np.minimum(penetration, FULL_DEPTH) / 2
    center = np.column_stack([spots.middle, level])
    columns = (center, spots.axis, spots.width, level - tip, quality)
    return rank_grasps(*(values[chosen] for values in columns))

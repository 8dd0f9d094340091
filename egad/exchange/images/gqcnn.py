"""Image sets as tensors that GQ-CNN is trained on: an image cut out around every grasp.

Mahler et al., "Dex-Net 2.0", RSS 2017. The folder is what `autolab_core.TensorDataset` opens.
"""

import json
import logging
from collections.abc import Iterable
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from egad.detectors import fill_missing
from egad.errors import UserError
from egad.grippers import Gripper
from egad.learning.images import RenderedImage, pose_values

log = logging.getLogger(__name__)
Image = NDArray[np.float32]
Tensors = dict[str, NDArray[Any]]

CROP, SIDE = 96, 32  # pixels cut out, and of the tensors
FILE = 1000  # rows per file
SPLIT = "object"
FIELDS: dict[str, tuple[str, tuple[int, ...]]] = {
    "depth_ims_tf_table": ("float32", (SIDE, SIDE, 1)),
    "obj_masks": ("uint8", (SIDE, SIDE, 1)),
    "hand_poses": ("float32", (7,)),
    "collision_free": ("uint32", ()),
    "obj_labels": ("uint32", ()),
    "pose_labels": ("uint32", ()),
    "image_labels": ("uint32", ()),
    "robust_ferrari_canny": ("float32", ()),
    "camera_poses": ("float32", (7,)),
    "camera_intrs": ("float32", (4,)),
}
DIMENSIONS = ("height", "width", "channels")


def write(pictures: Iterable[RenderedImage], gripper: Gripper, folder: Path) -> int:
    """Write a row for every reachable grasp in every image, and return how many there are.

    The split `object` is for training and validation; objects for testing are in neither, but in
    `test_indices.npz`.
    """
    del gripper
    (folder / "tensors").mkdir()
    objects: dict[str, int] = {}
    poses: dict[str, int] = {}
    splits: list[str] = []
    waiting = {name: np.empty((0, *shape), kind) for name, (kind, shape) in FIELDS.items()}
    for picture in pictures:
        number = objects.setdefault(picture.label, len(objects))
        pose = poses.setdefault(f"{picture.label}/{picture.objects[0].pose}", len(poses))
        rows = tensors(picture, number, pose)
        waiting = {key: np.concatenate([waiting[key], rows[key]]) for key in FIELDS}
        splits += [picture.split] * len(picture.grasps.u)
        waiting = _written(waiting, folder, len(splits))
    if not splits:
        raise UserError("these images have no reachable grasps, so there are no tensors to write")
    if len(splits) % FILE:
        _save(waiting, folder, len(splits) // FILE)
    maps = {"object_category_map.json": objects, "pose_category_map.json": poses}
    _describe(folder, maps, np.array(splits))
    log.info("%d rows", len(splits))
    return len(splits)


def tensors(picture: RenderedImage, object_number: int, pose_number: int) -> Tensors:
    """The rows of an image: `FIELDS`, each with one row per grasp.

    `hand_poses`: row, column, depth, angle (clockwise in the image), row and column from the
    optical axis, opening in pixels. Qualities are 0 for grasps that collide, as in Dex-Net.
    """
    grasps, camera = picture.grasps, picture.view.intrinsics
    count, pose = len(grasps.u), pose_values(picture.view.pose)
    hands = [
        grasps.v,
        grasps.u,
        grasps.depth_center,
        -grasps.angle % (2 * np.pi),
        grasps.v - camera.center[1],
        grasps.u - camera.center[0],
        grasps.opening,
    ]
    depth, mask = (
        fill_missing(picture.depth),
        np.where(picture.mask > 0, np.float32(255), np.float32(0)),
    )
    found = {
        "depth_ims_tf_table": cut_out(depth, picture, 1),
        "obj_masks": cut_out(mask, picture, 0),
        "hand_poses": np.stack(hands, axis=1),
        "collision_free": grasps.collision_free,
        "obj_labels": np.full(count, object_number),
        "pose_labels": np.full(count, pose_number),
        "image_labels": np.full(count, picture.image),
        "robust_ferrari_canny": np.where(grasps.collision_free, grasps.quality, 0),
        "camera_poses": np.tile(pose, (count, 1)),
        "camera_intrs": np.tile([camera.focal, camera.focal, *camera.center], (count, 1)),
    }
    return {name: found[name].astype(kind) for name, (kind, _) in FIELDS.items()}


def cut_out(image: Image, picture: RenderedImage, order: Literal[0, 1]) -> Image:
    """Every third of the 96 x 96 pixels about each grasp, axis along rows, (n, 32, 32, 1)."""
    grasps = picture.grasps
    steps = (np.arange(SIDE) - (SIDE - 1) / 2) * CROP / SIDE
    x, y = np.meshgrid(steps, steps)
    cosine, sine = (turn(grasps.angle)[:, None, None] for turn in (np.cos, np.sin))
    u = grasps.u[:, None, None] + cosine * x + sine * y
    v = grasps.v[:, None, None] - sine * x + cosine * y
    cut = ndimage.map_coordinates(image, np.stack([v, u]), order=order, mode="nearest")
    return np.asarray(cut)[..., None]


def _written(waiting: Tensors, folder: Path, total: int) -> Tensors:
    """Write all full files of the waiting rows, of `total` so far; returns the rest."""
    left = len(waiting["hand_poses"])
    while left >= FILE:
        head = {name: values[:FILE] for name, values in waiting.items()}
        _save(head, folder, (total - left) // FILE)
        waiting = {name: values[FILE:] for name, values in waiting.items()}
        left -= FILE
    return waiting


def _save(rows: Tensors, folder: Path, number: int) -> None:
    for name, values in rows.items():
        np.savez_compressed(folder / "tensors" / f"{name}_{number:05d}.npz", values)


def _describe(folder: Path, maps: dict[str, dict[str, int]], splits: NDArray[np.str_]) -> None:
    """Write the files beside the tensors: their shapes, what numbers mean, and the split."""
    fields = {
        name: {"dtype": kind, **dict(zip(DIMENSIONS, shape, strict=False))}
        for name, (kind, shape) in FIELDS.items()
    }
    _json(folder / "config.json", {"datapoints_per_file": FILE, "fields": fields})
    _json(folder / "metadata.json", {})
    for name, numbers in maps.items():
        _json(folder / name, numbers)
    place = folder / "splits" / SPLIT
    place.mkdir(parents=True)
    for name, split in (("train", "train"), ("val", "validation"), ("test", "test")):
        np.savez_compressed(place / f"{name}_indices.npz", np.flatnonzero(splits == split))
    _json(place / "metadata.json", {"field_name": "obj_labels"})


def _json(path: Path, value: object) -> None:
    path.write_text(json.dumps(value, indent=2, sort_keys=True) + "\n", encoding="utf-8")

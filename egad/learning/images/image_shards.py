"""Compact image sets: Parquet shards whose rows are images, compressed, with their grasps.

    images = read("results/egad/images/egad_75mm", split="train")
    images[0].depth, images[0].grasps.u

`Images` is a dataset for a torch `DataLoader(images, collate_fn=list)`; pictures are decoded when
they are asked for. Depth and mask are PNG files, poses and grasps are numbers.
"""

import io
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, overload

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from PIL import Image
from scipy.spatial.transform import Rotation

from egad._util.arrays import Floats
from egad.detectors import Intrinsics, View
from egad.errors import TableError, check_name
from egad.learning.images.rectangles import ImageGrasps
from egad.learning.images.rendering import ImagedObject, RenderedImage
from egad.learning.images.splits import SPLITS
from egad.learning.shards import shard_files
from egad.tables import parquet
from egad.tables.columns import POSE_PARTS
from egad.tables.images import IMAGES, LISTS

UNIT = 1e-4  # metres; of the depths in the files
LEVEL = 6  # of compression
PLAIN = ("image", "scene", "id", "label", "split", "draws")


def coded(depth: NDArray[np.float32]) -> NDArray[np.uint16]:
    """Depths in units of 0.1 mm; 0 for what is missing or deeper than 6.5 m."""
    steps = np.round(depth.astype(np.float64) / UNIT)
    known = np.isfinite(steps) & (steps < 2**16)
    return np.where(known, steps, 0).astype(np.uint16)


def png(pixels: NDArray[np.uint16] | NDArray[np.uint8]) -> bytes:
    """A PNG file of one channel."""
    buffer = io.BytesIO()
    Image.fromarray(pixels).save(buffer, "png", compress_level=LEVEL)
    return buffer.getvalue()


def depth_of(row: Mapping[str, Any]) -> NDArray[np.float32]:
    """The depths of a row, metres, NaN where they are missing; errors as `pixels`."""
    steps = pixels(row, "depth", "I")
    return np.where(steps > 0, steps * UNIT, np.nan).astype(np.float32)


def pixels(row: Mapping[str, Any], name: str, mode: str) -> NDArray[np.integer]:
    """Pixels of a PNG file of a row, (height, width) as it says; TableError if of another mode."""
    try:
        with Image.open(io.BytesIO(row[name]), formats=["PNG"]) as image:
            if image.size != (row["width"], row["height"]) or not image.mode.startswith(mode):
                raise ValueError("its size or type differs from the declared one")
            return np.asarray(image)
    except (ValueError, OSError, SyntaxError, TypeError, Image.DecompressionBombError) as error:
        raise TableError(f"its {name} cannot be read: {error}") from error


def encoded(picture: RenderedImage) -> dict[str, Any]:
    """The row of `tables.images.IMAGES` of a picture."""
    height, width = picture.depth.shape
    intrinsics = picture.view.intrinsics
    grasps, camera = picture.grasps, pose_values(picture.view.pose)
    return {
        **{name: getattr(picture, name) for name in PLAIN},
        "objects": [each.id for each in picture.objects],
        "factors": [each.factor for each in picture.objects],
        "poses": [each.pose for each in picture.objects],
        "placements": [n for each in picture.objects for n in pose_values(each.matrix)],
        "depth": png(coded(picture.depth)),
        "mask": png(picture.mask),
        "height": height,
        "width": width,
        "focal": intrinsics.focal,
        "center_u": intrinsics.center[0],
        "center_v": intrinsics.center[1],
        **{f"camera_{part}": value for part, value in zip(POSE_PARTS, camera, strict=True)},
        **{name: getattr(grasps, name) for name in LISTS},
    }


def decoded(row: Mapping[str, Any]) -> RenderedImage:
    """The picture of a row of `tables.images.IMAGES`; TableError if a PNG file is damaged."""
    placements = np.reshape(row["placements"], (-1, len(POSE_PARTS)))
    return RenderedImage(
        **{name: row[name] for name in PLAIN},
        objects=tuple(
            ImagedObject(name, float(factor), int(pose), pose_matrix(placement))
            for name, factor, pose, placement in zip(
                row["objects"], row["factors"], row["poses"], placements, strict=True
            )
        ),
        view=view_of(row, np.array([float(row[f"camera_{part}"]) for part in POSE_PARTS])),
        grasps=ImageGrasps(*(np.asarray(row[name]) for name in LISTS)),
    )


def view_of(row: Mapping[str, Any], camera: Floats) -> View:
    """The view of a row, given position and quaternion of its camera; errors as `pixels`."""
    center = (float(row["center_u"]), float(row["center_v"]))
    intrinsics = Intrinsics(row["width"], row["height"], float(row["focal"]), center)
    depth, mask = depth_of(row), pixels(row, "mask", "L").astype(np.uint8)
    return View(depth, intrinsics, pose_matrix(camera), mask)


def pose_values(matrix: Floats) -> list[float]:
    """Position and quaternion (x, y, z, w) of a transform (4, 4)."""
    quaternion = Rotation.from_matrix(matrix[:3, :3]).as_quat(canonical=True)
    return [*matrix[:3, 3].tolist(), *quaternion.tolist()]


def pose_matrix(values: Floats) -> Floats:
    """The transform, (4, 4), of a position and a quaternion: the inverse of `pose_values`."""
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_quat(values[3:]).as_matrix()
    matrix[:3, 3] = values[:3]
    return matrix


def files(folder: Path) -> list[Path]:
    """The shards of a folder, in the order of their images; UserError unless they are one set."""
    made = "the workflow (targets.render)"
    return [path for (path,) in shard_files(folder, ["images"], made)]


class Images(Sequence[RenderedImage]):
    """The images of a set, in the order of their numbers, decoded one by one.

    Attributes:
        table: Their rows: all columns of `tables.images.IMAGES`, pictures as PNG files.
    """

    def __init__(self, table: pd.DataFrame) -> None:
        self.table = table

    def __len__(self) -> int:
        return len(self.table)

    @overload
    def __getitem__(self, index: int) -> RenderedImage: ...
    @overload
    def __getitem__(self, index: slice) -> "Images": ...
    def __getitem__(self, index: int | slice) -> "RenderedImage | Images":
        if isinstance(index, slice):
            return Images(self.table.iloc[index])
        return decoded({str(name): value for name, value in self.table.iloc[index].items()})


def read(folder: str | Path, split: str | None = None) -> Images:
    """The images of a folder; they stay compressed in memory, some 10 kB each.

    Args:
        folder: With `images-N.parquet`.
        split: `train`, `validation` or `test`; all of them if None.

    Raises:
        UserError: Shards are missing, or are not all of one set; there is no such split.
        TableError: A shard is damaged.
    """
    parts = list(shards(folder, split))
    return Images(pd.concat(parts, ignore_index=True) if parts else parquet.empty(IMAGES))


def shards(folder: str | Path, split: str | None = None) -> Iterator[pd.DataFrame]:
    """The rows of one shard after the other: arguments and errors are those of `read`."""
    if split is not None:
        check_name("split", split, SPLITS)
    for path in files(Path(folder)):
        table = parquet.read(path, IMAGES)
        yield table if split is None else table[table["split"] == split]

"""Compact image sets: Parquet shards whose rows are images, compressed, with their grasps.

    images = read("results/egad/images/egad_75mm", split="train")
    images[0].depth, images[0].grasps.u

`Images` is what a torch `DataLoader` takes; pictures are decoded when they are asked for.
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

from egad.errors import UserError
from egad.names import known
from egad.tables import parquet
from egad.tables.columns import POSE_PARTS
from egad.tables.images import IMAGES, LISTS
from egad.vision.camera import Intrinsics, View
from egad.vision.projection import Rectangles
from egad.vision.rendering import Picture
from egad.vision.splits import SPLITS

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

UNIT = 1e-4  # metres; of the depths in the files
PNG_LEVEL = 6


class Images(Sequence[Picture]):
    """The images of a set, in the order of their numbers, decoded one by one.

    Attributes:
        table: Their rows: all columns of `tables.images.IMAGES`, pictures as PNG files.
    """

    def __init__(self, table: pd.DataFrame) -> None:
        self.table = table

    def __len__(self) -> int:
        return len(self.table)

    @overload
    def __getitem__(self, index: int) -> Picture: ...
    @overload
    def __getitem__(self, index: slice) -> "Images": ...
    def __getitem__(self, index: int | slice) -> "Picture | Images":
        if isinstance(index, slice):
            return Images(self.table.iloc[index])
        return decoded({str(name): value for name, value in self.table.iloc[index].items()})


def read(folder: str | Path, split: str | None = None) -> Images:
    """The images of a folder; they stay compressed in memory, some 8 kB each.

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
        known("split", split, SPLITS)
    for path in files(Path(folder)):
        table = parquet.read(path, IMAGES)
        yield table if split is None else table[table["split"] == split]


def files(folder: Path) -> list[Path]:
    """The shards of a folder, in the order of their images.

    Raises:
        UserError: Some are missing, or are not all of one set.
        TableError: One is damaged.
    """
    found = sorted(folder.glob("images-*.parquet"))
    if not found:
        raise UserError(f"{folder}: no images here; `egad render` and the workflow make them")
    notes = {path.name: parquet.notes(path) for path in found}
    totals = {each.get("shards") for each in notes.values()}
    if len(totals) > 1 or not isinstance(total := totals.pop(), int):
        raise UserError(f"{folder}: its shards are of several sets; render them again")
    whole = [f"images-{number}.parquet" for number in range(total)]
    if missing := [name for name in whole if name not in notes]:
        raise UserError(f"{folder}: half written, {_listed(missing)} of {total} shards missing")
    return [folder / name for name in whole]


def encoded(picture: Picture) -> dict[str, Any]:
    """The row of `tables.images.IMAGES` of a picture."""
    height, width = picture.depth.shape
    intrinsics = picture.view.intrinsics
    grasps = picture.grasps
    return {
        **{name: getattr(picture, name) for name in ("image", "id", "label", "split", "pose")},
        "depth": png(coded(picture.depth)),
        "mask": png(np.where(picture.mask, np.uint8(255), np.uint8(0))),
        "height": height,
        "width": width,
        "focal": intrinsics.focal,
        "center_u": intrinsics.center[0],
        "center_v": intrinsics.center[1],
        **_pose_columns("camera", picture.view.pose),
        **_pose_columns("object", picture.matrix),
        **{name: getattr(grasps, name) for name in LISTS},
    }


def decoded(row: Mapping[str, Any]) -> Picture:
    """The picture of a row of `tables.images.IMAGES`."""
    center = (float(row["center_u"]), float(row["center_v"]))
    intrinsics = Intrinsics(row["width"], row["height"], float(row["focal"]), center)
    codes = np.asarray(Image.open(io.BytesIO(row["depth"])))
    depth = np.where(codes > 0, codes * UNIT, np.nan).astype(np.float32)
    return Picture(
        image=int(row["image"]),
        id=row["id"],
        label=row["label"],
        split=row["split"],
        pose=int(row["pose"]),
        view=View(depth, intrinsics, _pose_matrix("camera", row)),
        mask=np.asarray(Image.open(io.BytesIO(row["mask"]))) > 0,
        matrix=_pose_matrix("object", row),
        grasps=Rectangles(*(np.asarray(row[name]) for name in LISTS)),
    )


def coded(depth: NDArray[np.float32]) -> NDArray[np.uint16]:
    """Depths in units of 0.1 mm; 0 for what is missing or deeper than 6.5 m."""
    steps = np.round(depth.astype(np.float64) / UNIT)
    known = np.isfinite(steps) & (steps < 2**16)
    return np.where(known, steps, 0).astype(np.uint16)


def png(pixels: NDArray[np.uint16] | NDArray[np.uint8]) -> bytes:
    """A PNG file of one channel."""
    buffer = io.BytesIO()
    Image.fromarray(pixels).save(buffer, "png", compress_level=PNG_LEVEL)
    return buffer.getvalue()


def _pose_columns(name: str, matrix: Floats) -> dict[str, float]:
    quaternion = Rotation.from_matrix(matrix[:3, :3]).as_quat(canonical=True)
    values = [*matrix[:3, 3].tolist(), *quaternion.tolist()]
    return {f"{name}_{part}": value for part, value in zip(POSE_PARTS, values, strict=True)}


def _pose_matrix(name: str, row: Mapping[str, Any]) -> Floats:
    values = [float(row[f"{name}_{part}"]) for part in POSE_PARTS]
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_quat(values[3:]).as_matrix()
    matrix[:3, 3] = values[:3]
    return matrix


def _listed(names: list[str]) -> str:
    few = ", ".join(names[:3])
    return few if len(names) <= 3 else f"{few} and {len(names) - 3} more"

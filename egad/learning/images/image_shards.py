"""Compact image sets: Parquet shards whose rows are images, compressed, with their grasps.

    images = read("results/egad/images/egad_75mm", split="train")
    images[0].depth, images[0].grasps.u

`Images` is a dataset for a torch `DataLoader(images, collate_fn=list)`; pictures are decoded when
they are asked for.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import overload

import pandas as pd

from egad.errors import check_name
from egad.learning.images.image_rows import decoded
from egad.learning.images.rendering import RenderedImage
from egad.learning.images.splits import SPLITS
from egad.tables import parquet
from egad.tables.images import IMAGES
from egad.tables.shards import shard_files


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

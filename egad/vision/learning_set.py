"""Rendered images with their grasps, read on demand from the shards of the compact layout."""

from collections import OrderedDict
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from threading import Lock
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from egad.errors import TableError, UserError
from egad.tables.row_groups import RowGroups
from egad.vision.folder import files
from egad.vision.maps import SIZE
from egad.vision.png import depth_of, pixels
from egad.vision.rectangles import Rectangles, half_turn
from egad.vision.splits import SPLITS

GRASP = ["u", "v", "angle", "opening", "depth_center", "quality", "free"]
NAMES = ["image", "id", "split", "depth", "mask", "height", "width", "focal", *GRASP]
WINDOW = 2048  # images that are mixed with each other; about so many are kept in memory, packed
FARTHEST = 1e5  # pixels; numbers of grasps beyond this are no pixels of an image


class Rule(NamedTuple):
    """Which grasps are shown to a network, and as what.

    Attributes:
        quality: Robust quality that a grasp must have more of; it must be free of collision, too.
        breadth: Of the jaws, metres.
    """

    quality: float
    breadth: float


class LearningSet:
    """All images of a folder.

    Attributes:
        folder: Where they are.
        index: A row an image: `shard`, `group` and `row` where it is stored; `image`, `id` and
            `split`; `grasps`, how many it shows, and `positive`, how many of these are so by the
            rule.
    """

    def __init__(self, folder: Path, rule: Rule) -> None:
        """Look through the shards; no image is decoded.

        Args:
            folder: Holds `images-0.parquet`, `images-1.parquet` and so on.
            rule: Which grasps are positive.

        Raises:
            UserError: Some are missing, or are not all of one set.
            TableError: One cannot be read, or is not of this layout.
        """
        self.folder, self.rule = folder, rule
        self._files = [RowGroups(path, NAMES) for path in files(folder)]
        self.index = pd.concat(
            [
                self._indexed(shard, group)
                for shard, file in enumerate(self._files)
                for group in range(len(file.sizes))
            ]
            or [_no_images()],
            ignore_index=True,
        )
        if unknown := set(self.index["split"]) - set(SPLITS):
            raise UserError(f"{folder}: the split {unknown.pop()!r} is none of {', '.join(SPLITS)}")
        self._kept: OrderedDict[tuple[int, int], pd.DataFrame] = OrderedDict()
        self._lock = Lock()

    def __reduce__(self) -> tuple[type["LearningSet"], tuple[Path, Rule]]:
        """A copy for another process looks through the shards anew."""
        return LearningSet, (self.folder, self.rule)

    def numbers(self, split: str) -> NDArray[np.int64]:
        """Rows of the index that belong to a split.

        Raises:
            UserError: There are none.
        """
        found = np.flatnonzero(self.index["split"] == split)
        if len(found) == 0:
            raise UserError(f"{self.folder}: no image is of the split {split}")
        return found

    def image(self, number: int) -> tuple[NDArray[np.float32], Rectangles]:
        """The image of a row of the index.

        Returns:
            Depth, (300, 300) metres, not a number where it is missing; and its positive grasps,
            from the worst to the best.

        Raises:
            TableError: It is damaged or of another size.
        """
        with self._named(number) as shown:
            return _whole(shown), positives(shown, self.rule)

    def mask(self, number: int) -> NDArray[np.bool_]:
        """Which pixels of it see the object, (300, 300); errors as `image`."""
        with self._named(number) as shown:
            return pixels(shown, "mask", "L") > 0

    @contextmanager
    def _named(self, number: int) -> Iterator[dict[str, Any]]:
        """What is stored of the image of a row of the index; what is wrong with it is told so."""
        place = self.index.iloc[number]
        row = self._group(place["shard"], place["group"]).iloc[place["row"]]
        try:
            yield {str(name): value for name, value in row.items()}
        except (ValueError, TypeError, TableError) as error:
            raise TableError(f"{self.folder}: image {place['image']}: {error}") from error

    def _group(self, shard: int, group: int) -> pd.DataFrame:
        """The rows of a group; the last ones used stay in memory."""
        key = (shard, group)
        with self._lock:
            if key not in self._kept:
                names = [name for name in NAMES if name not in ("id", "split")]
                self._kept[key] = self._files[shard].read(group, names)
                while len(self._kept) > 1 and sum(map(len, self._kept.values())) > 2 * WINDOW:
                    self._kept.popitem(last=False)
            self._kept.move_to_end(key)
            return self._kept[key]

    def _indexed(self, shard: int, group: int) -> pd.DataFrame:
        frame = self._files[shard].read(group, ["image", "id", "split", "quality", "free"])
        good = [
            int(positive(quality, free, self.rule).sum())
            for quality, free in zip(frame["quality"], frame["free"], strict=True)
        ]
        return frame[["image", "id", "split"]].assign(
            shard=shard,
            group=group,
            row=np.arange(len(frame)),
            grasps=frame["quality"].map(len),
            positive=good,
        )


def positive(quality: Any, free: Any, rule: Rule) -> NDArray[np.bool_]:  # noqa: ANN401
    """Which grasps of an image are free of collision and good enough, (n,)."""
    good: NDArray[np.bool_] = np.asarray(free, bool) & (np.asarray(quality, float) > rule.quality)
    return good


def _whole(shown: Mapping[str, Any]) -> NDArray[np.float32]:
    """The depth image of a row of a shard, of the size that goes in, with some depth in it."""
    if (shown["height"], shown["width"]) != (SIZE, SIZE):
        raise ValueError(f"it is {shown['width']} x {shown['height']}, not {SIZE} x {SIZE}")
    depth = depth_of(shown)
    if not np.isfinite(depth).any():
        raise ValueError("it has no depth at any pixel")
    return depth


def positives(shown: Mapping[str, Any], rule: Rule) -> Rectangles:
    """The positive grasps of a row of a shard, (n, 5), from the worst to the best.

    Raises:
        ValueError: Lists are of unequal lengths, or numbers are no pixels.
    """
    lists = [np.asarray(shown[name], dtype=np.float64) for name in GRASP]
    if len(set(map(len, lists))) > 1:
        raise ValueError("the lists of its grasps are not of equal lengths")
    u, v, angle, opening, depth, quality, free = lists
    rows = np.flatnonzero(positive(quality, free, rule))
    rows = rows[np.argsort(quality[rows], kind="stable")]
    with np.errstate(divide="ignore", invalid="ignore"):
        breadth = rule.breadth * shown["focal"] / depth
        found = np.column_stack([u, v, half_turn(angle), opening, breadth])[rows]
    if not (np.abs(found) < FARTHEST).all() or (found[:, 3:] < 0).any():
        raise ValueError("a grasp of it has numbers that are no pixels")
    return found


def _no_images() -> pd.DataFrame:
    names = ["image", "id", "split", "shard", "group", "row", "grasps", "positive"]
    return pd.DataFrame({name: [] for name in names})

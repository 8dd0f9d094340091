"""Training examples: images read on demand, in an order that follows from the seed alone.

A stream has a length and gives its examples by number, so that a `torch.utils.data.DataLoader`
takes it as it is, with any number of workers, and training can resume anywhere.
"""

from collections import OrderedDict
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from threading import Lock
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from egad.detectors import SIZE, fill_missing, prepare_input
from egad.errors import TableError, UserError
from egad.learning.augmentation import (
    WHOLE,
    Change,
    Crop,
    change_depth,
    change_rectangles,
    crop_rectangles,
    mean_depth,
    sample_change,
    sample_crop,
)
from egad.learning.images import Rectangles, check_splits, depth_of, files, half_turn, pixels
from egad.learning.targets import targets
from egad.random import generator
from egad.tables import parquet
from egad.tables.parquet import RowGroups

GRASP = ["u", "v", "angle", "opening", "depth_center", "quality"]
SIMULATED = "simulated_success"
NAMES = ["image", "id", "objects", "split", "depth", "mask", "height", "width", "focal", *GRASP]
WINDOW = 2048  # images that are shuffled together; about as many are kept in memory, packed
BREADTH = 0.02  # metres: width of the jaws in the training labels
ZOOM = (0.5, 1.0)  # of an image's side: the part that is enlarged to the whole side
FARTHEST = 1e5  # pixels; numbers of grasps beyond this are not pixels of an image


class PositiveFilter(NamedTuple):
    """Which grasps are positive: those free of collisions, with a robust quality above `quality`.

    If `simulated`, those that held in simulation instead. `breadth` is the width of the jaws along
    their face, metres.
    """

    quality: float
    breadth: float = BREADTH
    simulated: bool = False

    @property
    def columns(self) -> list[str]:
        """The columns of the images that it reads."""
        return ["collision_free", SIMULATED if self.simulated else "quality"]


class ImageDataset:
    """All images of some folders, as one set.

    The index has a row per image: `shard`, `group` and `row`, where it is stored, shards counted
    through all folders; `image`, `id`, `objects`, `split`; and its numbers of `grasps` and of
    `positive` ones.
    """

    def __init__(self, folders: Sequence[Path], rule: PositiveFilter) -> None:
        """Look through `images-N.parquet` of each folder; no image is decoded.

        UserError if some are missing, or not all of one set, or an object is in two splits;
        TableError if one cannot be read, or is not of this layout.
        """
        self.folders, self.rule = folders, rule
        self._names = list(dict.fromkeys([*NAMES, *rule.columns]))
        self._paths = [path for folder in folders for path in files(folder)]
        self._files = [RowGroups(path, self._names) for path in self._paths]
        self.index = pd.concat(
            [
                self._indexed(shard, group)
                for shard, file in enumerate(self._files)
                for group in range(len(file.sizes))
            ]
            or [_no_images()],
            ignore_index=True,
        )
        check_splits(self.index, self)
        self._kept: OrderedDict[tuple[int, int], pd.DataFrame] = OrderedDict()
        self._lock = Lock()

    def __reduce__(self) -> tuple[type["ImageDataset"], tuple[Sequence[Path], PositiveFilter]]:
        return ImageDataset, (self.folders, self.rule)

    def __str__(self) -> str:
        return ", ".join(map(str, self.folders))

    def indices(self, split: str) -> NDArray[np.int64]:
        """Rows of the index that belong to a split; UserError if there are none."""
        found = np.flatnonzero(self.index["split"] == split)
        if len(found) == 0:
            raise UserError(f"{self}: no image in the split {split}")
        return found

    def image(self, number: int) -> tuple[NDArray[np.float32], Rectangles]:
        """Depth, (300, 300) metres, NaN where missing, and positive grasps, from worst to best.

        By the row of the index; TableError if the image is damaged or of another size.
        """
        with self._named(number) as shown:
            return _whole(shown), positives(shown, self.rule)

    def mask(self, number: int) -> NDArray[np.bool_]:
        """Which pixels of it see the first object, (300, 300); errors as `image`."""
        with self._named(number) as shown:
            return np.asarray(pixels(shown, "mask", "L") == 1)

    @contextmanager
    def _named(self, number: int) -> Iterator[dict[str, Any]]:
        """The stored data of the image of a row of the index; errors in it name the image."""
        place = self.index.iloc[number]
        row = self._group(place["shard"], place["group"]).iloc[place["row"]]
        try:
            yield {str(name): value for name, value in row.items()}
        except (ValueError, TypeError, TableError) as error:
            folder = self._paths[place["shard"]].parent
            raise TableError(f"{folder}: image {place['image']}: {error}") from error

    def _group(self, shard: int, group: int) -> pd.DataFrame:
        """The rows of a group; the last ones used stay in memory."""
        key = (shard, group)
        with self._lock:
            if key not in self._kept:
                names = [name for name in self._names if name not in ("id", "objects", "split")]
                self._kept[key] = self._files[shard].read(group, names)
                while len(self._kept) > 1 and sum(map(len, self._kept.values())) > 2 * WINDOW:
                    self._kept.popitem(last=False)
            self._kept.move_to_end(key)
            return self._kept[key]

    def _indexed(self, shard: int, group: int) -> pd.DataFrame:
        columns = self.rule.columns
        frame = self._files[shard].read(group, ["image", "id", "objects", "split", *columns])
        good = [int(positive(row, self.rule).sum()) for row in parquet.records(frame[columns])]
        return frame[["image", "id", "objects", "split"]].assign(
            shard=shard,
            group=group,
            row=np.arange(len(frame)),
            grasps=frame["collision_free"].map(len),
            positive=good,
        )


def positive(shown: Mapping[str, Any], rule: PositiveFilter) -> NDArray[np.bool_]:
    """Which of n grasps of an image are positive, (n,); by `simulated`, none that has no value."""
    free, value = (np.asarray(shown[name]) for name in rule.columns)
    good = value.astype(bool) if rule.simulated else value.astype(float) > rule.quality
    both: NDArray[np.bool_] = free.astype(bool) & good
    return both


def _whole(shown: Mapping[str, Any]) -> NDArray[np.float32]:
    """The depth image of a row of a shard, of the input size, with some depth in it."""
    if (shown["height"], shown["width"]) != (SIZE, SIZE):
        raise ValueError(f"it is {shown['width']} x {shown['height']}, not {SIZE} x {SIZE}")
    depth = depth_of(shown)
    if not np.isfinite(depth).any():
        raise ValueError("it has no depth at any pixel")
    return depth


def positives(shown: Mapping[str, Any], rule: PositiveFilter) -> Rectangles:
    """Positive grasps of a row of a shard, (n, 5), worst to best; ValueError if no pixels."""
    names = [*GRASP, *rule.columns]
    if len({len(shown[name]) for name in names}) > 1:
        raise ValueError("the lists of its grasps are not of equal lengths")
    u, v, angle, opening, depth, quality = (np.asarray(shown[name], float) for name in GRASP)
    rows = np.flatnonzero(positive(shown, rule))
    rows = rows[np.argsort(quality[rows], kind="stable")]
    with np.errstate(divide="ignore", invalid="ignore"):
        breadth = rule.breadth * shown["focal"] / depth
        found = np.column_stack([u, v, half_turn(angle), opening, breadth])[rows]
    if not (np.abs(found) < FARTHEST).all() or (found[:, 3:] < 0).any():
        raise ValueError("one of its grasps has numbers that are not pixels")
    return found


def _no_images() -> pd.DataFrame:
    names = ["image", "id", "objects", "split", "shard", "group", "row", "grasps", "positive"]
    return pd.DataFrame({name: [] for name in names})


class Passes:
    """Labels of an index by the numbers of examples: pass after pass, each label once per pass."""

    def __init__(
        self,
        index: pd.DataFrame,
        seed: int,
        together: Sequence[str] = ("shard", "group"),
        window: int | None = None,
    ) -> None:
        """Shuffle nothing yet; arguments as for `order`."""
        self._index, self._seed, self._together, self._window = index, seed, together, window
        self._kept: dict[int, NDArray[np.int64]] = {}  # the order of the last pass

    def __getitem__(self, number: int) -> int:
        times, place = divmod(number, len(self._index))
        found = self._kept.get(times)
        if found is None:
            found = order(self._index, self._seed, times, self._together, self._window)
            self._kept = {times: found}
        return int(found[place])


UNCHANGED = Change()
Example = tuple[NDArray[np.float32], NDArray[np.float32]]


class Stream:
    """Shuffled and changed training images: pass after pass, each image once per pass."""

    def __init__(self, shards: ImageDataset, length: int, crop: int = SIZE, seed: int = 0) -> None:
        """Show the split `train`; `crop` is the side of an example, pixels."""
        self._shards, self._length, self._seed = shards, length, seed
        self._crop = crop
        self._passes = Passes(shards.index.loc[shards.indices("train")], seed)

    def __len__(self) -> int:
        return self._length

    def __getitem__(self, number: int) -> Example:
        """An example by its number: input (1, crop, crop) and target maps (4, crop, crop)."""
        if not 0 <= number < self._length:
            raise IndexError(number)
        depth, rectangles = self._shards.image(self._passes[number])
        rng = generator(self._seed, "view", number)
        change = sample_change(ZOOM, rng)
        crop = sample_crop(change_rectangles(rectangles, change, SIZE), self._crop, rng)
        return example(depth, rectangles, change, crop)


def example(
    depth: NDArray[np.float32],
    rectangles: Rectangles,
    change: Change = UNCHANGED,
    crop: Crop = WHOLE,
) -> Example:
    """Input (1, side, side), minus its mean, and target (4, side, side), from depths in m."""
    filled = fill_missing(depth)
    seen = prepare_input(change_depth(filled, change, crop), mean_depth(filled, change))
    wanted = crop_rectangles(change_rectangles(rectangles, change, SIZE), crop)
    return seen[None], targets(wanted, crop.side)


def order(
    index: pd.DataFrame,
    seed: int,
    times: int,
    together: Sequence[str] = ("shard", "group"),
    window: int | None = None,
) -> NDArray[np.int64]:
    """Labels of an index, shuffled in groups of `together`, then in windows of `window` rows."""
    rng = generator(seed, "order", times)
    groups = [part.index.to_numpy() for _, part in index.groupby(list(together))]
    shuffled = [groups[number] for number in rng.permutation(len(groups))]
    ends = np.cumsum([len(part) for part in shuffled])
    first = np.flatnonzero(np.diff(ends // (window or WINDOW), prepend=0))
    windows = np.split(np.concatenate(shuffled), ends[first])
    return np.concatenate([rng.permutation(window) for window in windows])

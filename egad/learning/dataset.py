"""Training examples: images read on demand, in an order that follows from the seed alone.

A stream has a length and gives its examples by number, so that a `torch.utils.data.DataLoader`
takes it as it is, with any number of workers, and training can go on anywhere.
"""

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
from egad.learning.augmentation import Change, change_depth, change_rectangles, sample_change
from egad.learning.targets import SIZE, prepare_input, targets
from egad.perception import SPLITS, Rectangles, depth_of, files, fill_missing, half_turn, pixels
from egad.random import generator
from egad.tables.row_groups import RowGroups

GRASP = ["u", "v", "angle", "opening", "depth_center", "quality", "collision_free"]
NAMES = ["image", "id", "split", "depth", "mask", "height", "width", "focal", *GRASP]
WINDOW = 2048  # images that are shuffled together; about as many are kept in memory, packed
FARTHEST = 1e5  # pixels; numbers of grasps beyond this are no pixels of an image


class PositiveFilter(NamedTuple):
    """Which grasps are shown to a network, and as what.

    Attributes:
        quality: Robust quality that a grasp must have more of; it must be free of collision, too.
        breadth: Of the jaws, metres.
    """

    quality: float
    breadth: float


class Dataset:
    """All images of a folder.

    Attributes:
        folder: Where they are.
        index: One row per image: `shard`, `group` and `row` where it is stored; `image`, `id` and
            `split`; `grasps`, how many it shows, and `positive`, how many of these are positive
            by the rule.
    """

    def __init__(self, folder: Path, rule: PositiveFilter) -> None:
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

    def __reduce__(self) -> tuple[type["Dataset"], tuple[Path, PositiveFilter]]:
        """A copy for another process looks through the shards anew."""
        return Dataset, (self.folder, self.rule)

    def indices(self, split: str) -> NDArray[np.int64]:
        """Rows of the index that belong to a split.

        Raises:
            UserError: There are none.
        """
        found = np.flatnonzero(self.index["split"] == split)
        if len(found) == 0:
            raise UserError(f"{self.folder}: no image in the split {split}")
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
        frame = self._files[shard].read(
            group, ["image", "id", "split", "quality", "collision_free"]
        )
        good = [
            int(positive(quality, free, self.rule).sum())
            for quality, free in zip(frame["quality"], frame["collision_free"], strict=True)
        ]
        return frame[["image", "id", "split"]].assign(
            shard=shard,
            group=group,
            row=np.arange(len(frame)),
            grasps=frame["quality"].map(len),
            positive=good,
        )


def positive(quality: Any, free: Any, rule: PositiveFilter) -> NDArray[np.bool_]:  # noqa: ANN401
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


def positives(shown: Mapping[str, Any], rule: PositiveFilter) -> Rectangles:
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
        raise ValueError("one of its grasps has numbers that are not pixels")
    return found


def _no_images() -> pd.DataFrame:
    names = ["image", "id", "split", "shard", "group", "row", "grasps", "positive"]
    return pd.DataFrame({name: [] for name in names})


UNCHANGED = Change()
Example = tuple[NDArray[np.float32], NDArray[np.float32]]


class Stream:
    """Shuffled and changed training images: pass after pass, each image once a pass."""

    def __init__(
        self,
        shards: Dataset,
        length: int,
        zoom: tuple[float, float] = (0.5, 1.0),
        seed: int = 0,
    ) -> None:
        """Make a stream.

        Args:
            shards: The images; those of the split `train` are shown.
            length: How many examples there are.
            zoom: Least and greatest part of an image's side that is shown.
            seed: Order and changes follow from it.

        Raises:
            UserError: There are no such images.
        """
        self._shards, self._length, self._zoom, self._seed = shards, length, zoom, seed
        self._index = shards.index.loc[shards.indices("train")]
        self._passes: dict[int, NDArray[np.int64]] = {}

    def __len__(self) -> int:
        return self._length

    def __getitem__(self, number: int) -> Example:
        """An example by its number: input (1, 300, 300) and target maps (4, 300, 300)."""
        if not 0 <= number < self._length:
            raise IndexError(number)
        times, place = divmod(number, len(self._index))
        depth, rectangles = self._shards.image(self._order(times)[place])
        return example(
            depth, rectangles, sample_change(self._zoom, generator(self._seed, "view", number))
        )

    def _order(self, times: int) -> NDArray[np.int64]:
        """The order of a pass; that of the last one is kept."""
        found = self._passes.get(times)
        if found is None:
            found = order(self._index, self._seed, times)
            self._passes = {times: found}
        return found


def example(
    depth: NDArray[np.float32], rectangles: Rectangles, change: Change = UNCHANGED
) -> Example:
    """What a network gets and should answer, (1, 300, 300) and (4, 300, 300), after a change."""
    seen = change_depth(fill_missing(depth), change)
    return prepare_input(seen)[None], targets(change_rectangles(rectangles, change, SIZE))


def order(index: pd.DataFrame, seed: int, times: int) -> NDArray[np.int64]:
    """Labels of an index of images, shuffled, so that few row groups are open at a time.

    The groups are shuffled, and then the images of each `WINDOW` or so that follow one another.

    Args:
        index: Rows of `Dataset.index`.
        seed: The order follows from it,
        times: and from the number of the pass.
    """
    rng = generator(seed, "order", times)
    groups = [part.index.to_numpy() for _, part in index.groupby(["shard", "group"])]
    shuffled = [groups[number] for number in rng.permutation(len(groups))]
    ends = np.cumsum([len(part) for part in shuffled])
    windows = np.split(np.concatenate(shuffled), _window_ends(ends))
    return np.concatenate([rng.permutation(window) for window in windows])


def _window_ends(ends: NDArray[np.int64]) -> NDArray[np.int64]:
    """The ends of groups that are the first beyond each multiple of a window."""
    first = np.flatnonzero(np.diff(ends // WINDOW, prepend=0))
    return ends[first]

"""Examples for training: any number of images in an order that follows from a seed alone.

A stream has a length and gives its examples by number, so that a `torch.utils.data.DataLoader`
takes it as it is, with any number of workers, and training can go on anywhere.
"""

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from egad.seeds import generator
from egad.vision.augmentation import Change, changed_depth, changed_rectangles, drawn
from egad.vision.holes import filled
from egad.vision.learning_set import WINDOW, LearningSet
from egad.vision.maps import SIZE, prepared
from egad.vision.rectangles import Rectangles
from egad.vision.targets import targets

UNCHANGED = Change()
Example = tuple[NDArray[np.float32], NDArray[np.float32]]


class Stream:
    """Shuffled and changed training images: pass after pass, each image once a pass."""

    def __init__(
        self,
        shards: LearningSet,
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
        self._index = shards.index.loc[shards.numbers("train")]
        self._passes: dict[int, NDArray[np.int64]] = {}

    def __len__(self) -> int:
        return self._length

    def __getitem__(self, number: int) -> Example:
        """An example by its number: input (1, 300, 300) and target maps (4, 300, 300)."""
        if not 0 <= number < self._length:
            raise IndexError(number)
        times, place = divmod(number, len(self._index))
        depth, rectangles = self._shards.image(self._order(times)[place])
        return example(depth, rectangles, drawn(self._zoom, generator(self._seed, "view", number)))

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
    seen = changed_depth(filled(depth), change)
    return prepared(seen)[None], targets(changed_rectangles(rectangles, change, SIZE))


def order(index: pd.DataFrame, seed: int, times: int) -> NDArray[np.int64]:
    """Labels of an index of images, shuffled, so that few row groups are open at a time.

    The groups are shuffled, and then the images of each `WINDOW` or so that follow one another.

    Args:
        index: Rows of `LearningSet.index`.
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

"""How good a network is on labelled images: loss, rectangle score, and a simple baseline.

PyTorch, an extra, is needed only to judge a network.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from egad.bench.stats import mean_rate
from egad.detectors import read_maps
from egad.detectors.maps import best
from egad.learning.dataset import ImageDataset, example
from egad.learning.images import Rectangles, agrees, half_turn
from egad.tables.training import SCORE

if TYPE_CHECKING:
    import torch
    from torch import nn

MAPS = ("quality", "cosine", "sine", "width")


def narrow_side_grasp(mask: NDArray[np.bool_]) -> NDArray[np.float64]:
    """u, v, angle and opening, (4,), across the narrower side of a mask, pixels and radians."""
    rows, columns = np.nonzero(mask)
    points = np.stack([columns, -rows])
    axis = np.linalg.eigh(np.cov(points))[1][:, 0]
    u, up = points.mean(axis=1)
    angle = half_turn(np.arctan2(axis[1], axis[0]))
    return np.array([u, -up, angle, np.ptp(axis @ points) + 1], dtype=np.float64)


class OutlineScore(NamedTuple):
    """In how many images of one object the outline suggests a good grasp, of those with one."""

    n_correct: int
    n_images: int


def outline_score(shards: ImageDataset, numbers: Iterable[int]) -> OutlineScore:
    """The score of the outline in those rows of the index that show a single object."""
    chosen = shards.index.iloc[list(numbers)]
    alone = chosen.index[(chosen["objects"].map(len) == 1) & (chosen["positive"] > 0)]
    pairs = ((shards.mask(number), shards.image(number)[1]) for number in alone)
    right = sum(mask.sum() > 1 and agrees(narrow_side_grasp(mask), truth) for mask, truth in pairs)
    return OutlineScore(int(right), len(alone))


class ImageScore(NamedTuple):
    """Losses of the maps, (4,), and whether the best grasp agrees; None without a positive one."""

    losses: NDArray[np.float64]
    hit: bool | None


def score_image(network: "nn.Module", depth: NDArray[np.float32], truth: Rectangles) -> ImageScore:
    """Compare an answer, at the highest peak of its smoothed quality, with grasps (n, 5)."""
    import torch  # noqa: PLC0415 (an extra)

    with torch.inference_mode():
        seen, wanted = (torch.from_numpy(part)[None] for part in example(depth, truth))
        maps = network(seen)
        losses = map_losses(maps, wanted).double().numpy()
    if len(truth) == 0:
        return ImageScore(losses, None)
    if not np.isfinite(losses).all():
        return ImageScore(losses, hit=False)
    return ImageScore(losses, agrees(best(read_maps(maps[0].numpy())), truth))


def map_losses(maps: "torch.Tensor", wanted: "torch.Tensor") -> "torch.Tensor":
    """Mean squared error of each of the four maps, (4,), of maps (n, 4, height, width)."""
    return (maps - wanted).square().mean(dim=(0, 2, 3))


def score(judgements: Sequence[ImageScore]) -> float:
    """Part of the images with positive grasps in which the best one is correct; NaN if none."""
    hits = [each.hit for each in judgements if each.hit is not None]
    return float(np.mean(hits)) if hits else math.nan


@dataclass(frozen=True)
class Score:
    """What a network reached on images of held-out objects; `loss` is the mean over images."""

    n_correct: int
    n_images: int
    objects: int
    interval: tuple[float, float]
    loss: float

    @property
    def rate(self) -> float:
        """The part that is correct; NaN if no image counts."""
        return self.n_correct / self.n_images if self.n_images else math.nan


def total_score(index: pd.DataFrame, judgements: Sequence[ImageScore]) -> Score:
    """Combine the scores of images, which are rows of `ImageDataset.index`."""
    hits = [each.hit for each in judgements]
    table = pd.DataFrame({"label": index["id"], "objects": index["objects"], "success": hits})
    table = table[[hit is not None for hit in hits]]
    mean = mean_rate(table)
    objects = table["objects"].explode().nunique()
    loss = float(np.mean([each.losses.sum() for each in judgements]))
    return Score(mean.successes, mean.attempts, objects, mean.interval, loss)


def score_table(score: Score) -> pd.DataFrame:
    """The score as a table of one row, columns of `tables.training.SCORE`."""
    low, high = score.interval
    numbers = (score.n_correct, score.n_images, score.objects, low, high, score.loss)
    return pd.DataFrame([numbers], columns=SCORE.names)

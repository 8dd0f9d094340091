"""How good a network is on labelled images: its loss, and the field's usual score."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn

from egad.vision.maps import best, read
from egad.vision.rectangles import Rectangles, agrees
from egad.vision.stream import example

MAPS = ("quality", "cosine", "sine", "width")


class Judged(NamedTuple):
    """A network's answer to one image.

    Attributes:
        losses: Mean squared error of each map, (4,).
        hit: Whether its best grasp agrees with a positive one; none if there is no positive one.
    """

    losses: NDArray[np.float64]
    hit: bool | None


@torch.inference_mode()
def judged(network: nn.Module, depth: NDArray[np.float32], truth: Rectangles) -> Judged:
    """Compare a network's answer to an image with the positive grasps (n, 5) in it.

    The grasp that counts is the one at the highest peak of the smoothed quality
    (`egad.vision.rectangles.agrees` says how).
    """
    seen, wanted = (torch.from_numpy(part)[None] for part in example(depth, truth))
    maps = network(seen)
    losses = map_losses(maps, wanted).double().numpy()
    if len(truth) == 0:
        return Judged(losses, None)
    return Judged(losses, bool(np.isfinite(losses).all()) and agrees(_grasp(maps), truth))


def _grasp(maps: torch.Tensor) -> NDArray[np.float64]:
    return best(read(maps[0].numpy()))


def map_losses(maps: torch.Tensor, wanted: torch.Tensor) -> torch.Tensor:
    """Mean squared error of each of the four maps, (4,), of maps (n, 4, height, width)."""
    return torch.square(maps - wanted).mean(dim=(0, 2, 3))


def score(judgements: Sequence[Judged]) -> float:
    """Part of the images with positive grasps in which the best one was right; NaN if none."""
    hits = [each.hit for each in judgements if each.hit is not None]
    return float(np.mean(hits)) if hits else math.nan

"""What a network reaches on images of objects that it has not learnt from."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from egad.stats.rates import mean_rate
from egad.tables.training import SCORE

if TYPE_CHECKING:
    from egad.learning.evaluation import Judged


@dataclass(frozen=True)
class Score:
    """What a network reached on images of held-out objects.

    Attributes:
        right: Images in which its best grasp agrees with a positive one.
        count: Images with a positive grasp.
        objects: Objects in these.
        interval: Of the part that is right, for other objects of the same kind, 95 %.
        loss: Mean over all images.
    """

    right: int
    count: int
    objects: int
    interval: tuple[float, float]
    loss: float

    @property
    def rate(self) -> float:
        """The part that is right; NaN if no image counts."""
        return self.right / self.count if self.count else math.nan


def scored(index: pd.DataFrame, judgements: "Sequence[Judged]") -> Score:
    """Put the judgements of some images together.

    Args:
        index: Rows of `LearningSet.index`,
        judgements: and what was answered to each.
    """
    hits = [each.hit for each in judgements]
    table = pd.DataFrame({"label": index["id"].to_numpy(), "success": hits})
    table = table[[hit is not None for hit in hits]]
    mean = mean_rate(table)
    loss = float(np.mean([each.losses.sum() for each in judgements]))
    return Score(mean.successes, mean.attempts, table["label"].nunique(), mean.interval, loss)


def reached(score: Score) -> pd.DataFrame:
    """The score as a table of one row, columns of `tables.training.SCORE`."""
    low, high = score.interval
    numbers = (score.right, score.count, score.objects, low, high, score.loss)
    return pd.DataFrame([numbers], columns=SCORE.names)

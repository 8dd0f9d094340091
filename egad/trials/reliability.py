"""Does a detector know what it can do? Its quality against what came of it."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.stats import mannwhitneyu

from egad.trials.statistics import Rate

BINS = 10


@dataclass(frozen=True)
class Bin:
    """Attempts of similar quality.

    Attributes:
        quality: Their mean quality.
        rate: How often they succeeded.
    """

    quality: float
    rate: Rate


def reliability(trials: pd.DataFrame, bins: int = BINS) -> list[Bin]:
    """Success rates of attempts, binned by the quality that the detector gave.

    Args:
        trials: Columns quality and success; attempts without a quality are left out.
        bins: Most bins. Each holds about as many attempts; equal qualities stay together.

    Returns:
        From low to high quality; empty if no attempt has a quality.
    """
    quality, success = _known(trials)
    if len(quality) == 0:
        return []
    edges = np.unique(quality)[1:]
    if len(edges) >= bins:
        edges = np.unique(np.quantile(quality, np.linspace(0, 1, bins + 1)[1:-1]))
    number = np.searchsorted(edges, quality, side="right")
    return [
        Bin(float(quality[chosen].mean()), Rate(int(success[chosen].sum()), int(chosen.sum())))
        for chosen in (number == each for each in np.unique(number))
    ]


def discrimination(trials: pd.DataFrame) -> float:
    """How often a success had a higher quality than a failure: area under the ROC curve.

    Args:
        trials: Columns quality and success; attempts without a quality are left out.

    Returns:
        1 if quality tells all, 0.5 if it tells nothing (ties count half); NaN if there are no
        successes, or no failures.
    """
    quality, success = _known(trials)
    if success.all() or not success.any():
        return float("nan")
    better = mannwhitneyu(quality[success], quality[~success]).statistic
    return float(better / (success.sum() * (~success).sum()))


def _known(trials: pd.DataFrame) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Quality and success of the attempts with a quality."""
    quality = trials["quality"].to_numpy(dtype=np.float64)
    known = np.isfinite(quality)
    return quality[known], trials["success"].to_numpy(dtype=bool)[known]

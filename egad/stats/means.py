"""Means of independent runs compared, such as of networks that were trained from several seeds."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy  # scipy.stats is loaded when it is used

from egad._util.arrays import Floats
from egad.stats.rates import Interval

UNKNOWN: Interval = (float("nan"), float("nan"))


@dataclass(frozen=True)
class MeanDifference:
    """Mean of the runs of one kind minus that of another.

    Attributes:
        gain: The difference.
        interval: 95 % confidence interval for other runs.
        p: Two-sided p-value; NaN if both have a single run.
    """

    gain: float
    interval: Interval
    p: float


def difference_of_means(
    first: Sequence[float] | Floats, second: Sequence[float] | Floats
) -> MeanDifference:
    """Compare runs of two kinds by Welch's t test.

    If one has a single run, such as a detector that was not trained, the test is whether runs of
    the other kind are better or worse than this one (one-sample t test).

    Args:
        first: A number for each run of the first kind, such as the success of a network.
        second: The same of the second kind.
    """
    gain = float(np.mean(first) - np.mean(second))
    if len(first) == len(second) == 1:
        return MeanDifference(gain, UNKNOWN, float("nan"))
    if len(first) == 1:
        turned = difference_of_means(second, first)
        low, high = turned.interval
        return MeanDifference(gain, (-high, -low), turned.p)
    if len(second) == 1:
        found = scipy.stats.ttest_1samp(np.asarray(first) - second[0], 0)
    else:
        found = scipy.stats.ttest_ind(first, second, equal_var=False)
    interval = found.confidence_interval(0.95)
    return MeanDifference(gain, (float(interval.low), float(interval.high)), float(found.pvalue))


def holm(p_values: Floats) -> Floats:
    """P-values of several tests, so that any is below 0.05 by chance in at most 5 % of cases.

    The smallest of n is multiplied by n, the next by n - 1 and so on, and none is less than one
    before it (Holm 1979).

    Args:
        p_values: (n,); NaN counts as a test without a result.

    Returns:
        (n,) at most 1; NaN where it was.
    """
    order = np.argsort(p_values)  # NaN last
    steps = p_values[order] * np.arange(len(p_values), 0, -1)
    found = np.empty(len(p_values))
    found[order] = np.minimum(np.maximum.accumulate(steps), 1.0)
    return found

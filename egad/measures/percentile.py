"""A percentile of a sample, how certain it is, and values that are computed only if they matter."""

import math
from collections.abc import Callable

import numpy as np
from scipy.special import betainc

from egad._util.arrays import Floats, Ints

TIGHTNESS = 0.95  # a value is often less than this fraction of its bound


class BoundedSample:
    """Values with known upper bounds; the values themselves are computed on demand."""

    def __init__(self, compute: Callable[[Ints, float], Floats]) -> None:
        """Start without values; below a limit, `compute` may give any bound that is below it."""
        self._compute = compute
        self._upper = np.empty(0)  # the value itself where it is known
        self._known = np.empty(0, dtype=bool)

    def __len__(self) -> int:
        return len(self._upper)

    def extend(self, bounds: Floats, exact: bool = False) -> None:
        """Add values that are not negative, by their upper bounds or exactly."""
        self._upper = np.concatenate((self._upper, bounds))
        self._known = np.concatenate((self._known, exact | (bounds <= 0)))

    def smallest(self, rank: int) -> float:
        """The value at an index of the ascending values."""
        self._settle(TIGHTNESS * self._upper_at(rank))
        while self._settle(value := self._upper_at(rank)):
            pass
        return value

    def _upper_at(self, rank: int) -> float:
        return float(np.partition(self._upper, rank)[rank])

    def below(self, limit: float) -> int:
        """How many values are less than a limit."""
        self._settle(limit)
        return int(np.sum(self._upper < limit))

    def _settle(self, limit: float) -> bool:
        """Compute the values whose bound is at least a limit; returns whether there were any."""
        if limit <= 0:
            return False  # no value is below, and none has to be known
        open_ones = np.flatnonzero(~self._known & (self._upper >= limit))
        if len(open_ones):
            floor = TIGHTNESS * limit  # a little lower, so that the next limit asks for few
            self._upper[open_ones] = self._compute(open_ones, floor)
            self._known[open_ones] = self._upper[open_ones] >= floor
        return len(open_ones) > 0


def percentile(values: Floats, percent: float) -> float:
    """The value of this rank; see `percentile_rank`."""
    return float(np.sort(values)[percentile_rank(len(values), percent)])


def percentile_rank(count: int, percent: float) -> int:
    """The index of a percentile among n ascending values: n * percent / 100, not interpolated."""
    return min(int(count * percent / 100), count - 1)


def percentile_std(sample: BoundedSample, percent: float) -> float:
    """Standard error of a percentile of n independent values (Woodruff 1952); NaN if too few."""
    count, part = len(sample), percent / 100
    spread = np.sqrt(part * (1 - part) / count)
    low, high = np.floor(count * (part - spread)), np.ceil(count * (part + spread))
    if low < 0 or high >= count:
        return math.nan
    return (sample.smallest(int(high)) - sample.smallest(int(low))) / 2


def confidence_between(sample: BoundedSample, percent: float, limits: tuple[float, float]) -> float:
    """Probability that a percentile lies between two limits, by a beta distribution (Jeffreys)."""
    low, high = (_chance_above(sample, percent / 100, limit) for limit in limits)
    return max(low - high, 0.0)


def _chance_above(sample: BoundedSample, part: float, limit: float) -> float:
    """The probability that a percentile is at least a limit."""
    if not np.isfinite(limit):
        return float(limit < 0)
    below = sample.below(limit)
    return float(betainc(below + 0.5, len(sample) - below + 0.5, part))

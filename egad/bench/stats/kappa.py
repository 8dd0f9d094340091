"""Agreement of two yes-or-no labels of the same grasps: counts, and Cohen's kappa."""

from dataclasses import dataclass

import numpy as np

from egad._util.arrays import Flags, Floats, Ints
from egad.bench.stats.rates import Interval, Rate, bootstrap
from egad.bench.stats.roc import Names


@dataclass(frozen=True)
class Kappa:
    """How two labels of the same items agree.

    `value` is Cohen's kappa (1960): 1 if they always agree, 0 if as often as by chance, NaN if both
    labels are the same constant. The `interval`, of 95 %, resamples groups of items.
    """

    both: int
    only_first: int
    only_second: int
    neither: int
    value: float
    interval: Interval

    @property
    def agreement(self) -> Rate:
        """How often they agree."""
        total = self.both + self.only_first + self.only_second + self.neither
        return Rate(self.both + self.neither, total)


def cohen_kappa(first: Flags, second: Flags, groups: Names) -> Kappa:
    """Agreement of two labels (n,) of items; the interval resamples the groups (n,) of items."""
    names, owner = np.unique(groups, return_inverse=True)
    cells = [first & second, first & ~second, ~first & second, ~first & ~second]
    counts = np.stack([np.bincount(owner[cell], minlength=len(names)) for cell in cells])

    def kappas(drawn: Ints) -> Floats:
        both, only_first, only_second, neither = (each[drawn].sum(axis=-1) for each in counts)
        total = both + only_first + only_second + neither
        yes = (both + only_first) * (both + only_second)
        no = (only_second + neither) * (only_first + neither)
        with np.errstate(invalid="ignore", divide="ignore"):
            agreed, chance = (both + neither) / total, (yes + no) / total**2
            return np.asarray((agreed - chance) / np.where(chance < 1, 1 - chance, np.nan))

    both, only_first, only_second, neither = counts.sum(axis=1).tolist()
    value, interval = float(kappas(np.arange(len(names)))), bootstrap(kappas, len(names))
    return Kappa(both, only_first, only_second, neither, value, interval)

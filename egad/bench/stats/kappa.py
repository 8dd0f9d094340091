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
    counts = [np.bincount(owner[cell], minlength=len(names)) for cell in cells]

    def kappas(drawn: Ints) -> Floats:
        return _kappa(*(each[drawn].sum(axis=-1) for each in counts))

    value = float(kappas(np.arange(len(names))))
    both, only_first, only_second, neither = (int(each.sum()) for each in counts)
    interval = bootstrap(kappas, len(names))
    return Kappa(both, only_first, only_second, neither, value, interval)


def _kappa(both: Ints, only_first: Ints, only_second: Ints, neither: Ints) -> Floats:
    """Kappa of counts, (draws,) or numbers; NaN where chance alone agrees always, or none are."""
    total = both + only_first + only_second + neither
    with np.errstate(invalid="ignore", divide="ignore"):
        agreed = (both + neither) / total
        yes = (both + only_first) * (both + only_second)
        no = (only_second + neither) * (only_first + neither)
        chance = (yes + no) / total**2
        return np.asarray((agreed - chance) / np.where(chance < 1, 1 - chance, np.nan))

"""Ranks of several detectors that tried the same things: ties where they cannot be told apart."""

from collections.abc import Mapping
from itertools import combinations
from typing import NamedTuple

import numpy as np
import scipy  # scipy.stats is loaded when it is used

from egad._util.arrays import Ints
from egad.bench.stats.paired import ENOUGH_OBJECTS
from egad.bench.stats.rates import DRAWS, Interval, expanded_quantile
from egad.random import generator


class Lead(NamedTuple):
    """How far the first detector is ahead; the 95 % intervals of all pairs hold together."""

    first: str
    second: str
    difference: float
    interval: Interval

    @property
    def is_certain(self) -> bool:
        """Whether the first is better, and it is no tie."""
        return self.interval[0] > 0


class Ranks(NamedTuple):
    """The ranks that a detector may have, from 1 = best."""

    best: int
    worst: int

    def __str__(self) -> str:
        """`2`, or `2-4` with an en dash."""
        return str(self.best) if self.best == self.worst else f"{self.best}\N{EN DASH}{self.worst}"


def leads(successes: Mapping[str, Ints], sizes: Ints) -> list[Lead]:
    """All pairs of detectors, with simultaneous intervals of 95 % for other groups.

    Rates are sums of successes of each group, (n,), over sums of sizes. A half-width is the 95 %
    quantile over draws of groups of the largest deviation in standard errors, widened as in
    `bootstrap`. With fewer than 6 groups all pairs are ties.
    """
    pairs = list(combinations(successes, 2))
    count = len(sizes)
    if not pairs:
        return []
    gains = np.column_stack([successes[one] - successes[other] for one, other in pairs])
    differences = gains.sum(axis=0) / sizes.sum()
    rest = gains - differences * sizes[:, None]
    errors = np.sqrt((rest**2).sum(axis=0) * count / max(count - 1, 1)) / sizes.sum()
    widths = np.full(len(pairs), np.inf)
    if count >= ENOUGH_OBJECTS:
        drawn = generator(0, "bootstrap").multinomial(count, np.full(count, 1 / count), DRAWS)
        away = np.abs(drawn @ gains / (drawn @ sizes)[:, None] - differences)
        differ = errors > 0  # in the others, all gains are equal
        largest = (away[:, differ] / errors[differ]).max(axis=1, initial=0.0)
        wider = expanded_quantile(count) / scipy.stats.norm.ppf(0.975)
        widths = np.quantile(largest, 0.95) * wider * errors
    found = []
    for (one, other), value, width in zip(pairs, differences.tolist(), widths, strict=True):
        names = (one, other) if value >= 0 else (other, one)
        interval = float(abs(value) - width), float(abs(value) + width)
        found.append(Lead(*names, abs(value), interval))
    return found


def ranks(names: list[str], pairs: list[Lead]) -> dict[str, Ranks]:
    """Best and worst rank of each detector, by those certainly better or worse (Mogstad 2024)."""
    certain = [each for each in pairs if each.is_certain]
    better = {name: sum(each.second == name for each in certain) for name in names}
    worse = {name: sum(each.first == name for each in certain) for name in names}
    return {name: Ranks(1 + better[name], len(names) - worse[name]) for name in names}

"""Ranks of several detectors that tried the same things: ties where they cannot be told apart."""

from collections.abc import Mapping
from itertools import combinations
from typing import NamedTuple

import numpy as np
import scipy  # scipy.stats is loaded when it is used

from egad._util.arrays import Floats, Ints
from egad.random import generator
from egad.stats.paired import ENOUGH_OBJECTS
from egad.stats.rates import DRAWS, Interval


class Lead(NamedTuple):
    """How far one detector is ahead of another.

    Attributes:
        first: The one with the higher rate.
        second: The other one.
        difference: Of their rates.
        interval: Simultaneous 95 % interval: with a probability of 95 %, those of all pairs are
            right.
    """

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
    """All pairs of detectors, with simultaneous intervals of 95 % for other groups of their kind.

    Rates are sums of successes over the sum of sizes. Groups (objects, or rounds of clearing a
    table) are drawn with replacement, the same for all pairs. The interval of a pair is as many
    standard errors wide as the largest deviation of any difference is in 95 % of the draws, and
    widened for few groups as in `egad.stats.rates.bootstrap`.

    Args:
        successes: Of each group, (n,), by detector.
        sizes: Attempts or objects of each group, (n,).

    Returns:
        The pairs; ties if there are less than 6 groups, which cannot differ significantly.
    """
    pairs = list(combinations(successes, 2))
    count = len(sizes)
    if not pairs:
        return []
    gains = np.column_stack([successes[one] - successes[other] for one, other in pairs])
    differences, errors = _ratios(np.ones((1, count)), gains, sizes)
    widths = np.full(len(pairs), np.inf)
    if count >= ENOUGH_OBJECTS:
        drawn = generator(0, "bootstrap").multinomial(count, np.full(count, 1 / count), DRAWS)
        away = np.abs(_ratios(drawn, gains, sizes)[0] - differences)
        differ = errors[0] > 0  # of the others, all gains are equal
        largest = (away[:, differ] / errors[0, differ]).max(axis=1, initial=0.0)
        widths = np.quantile(largest, 0.95) * _small_sample(count) * errors[0]
    found = []
    for (one, other), value, width in zip(pairs, differences[0].tolist(), widths, strict=True):
        names = (one, other) if value >= 0 else (other, one)
        interval = float(abs(value) - width), float(abs(value) + width)
        found.append(Lead(*names, abs(value), interval))
    return found


def _small_sample(count: int) -> float:
    """What makes a bootstrap interval wider for few groups (Hesterberg 2015)."""
    normal, student = scipy.stats.norm.ppf(0.975), scipy.stats.t.ppf(0.975, count - 1)
    return float(np.sqrt(count / (count - 1)) * student / normal)


def _ratios(weights: Floats | Ints, gains: Ints, sizes: Ints) -> tuple[Floats, Floats]:
    """Sums of gains over sums of sizes with their standard errors, (draws, pairs)."""
    total = (weights @ sizes)[:, None]
    ratios = weights @ gains / total
    squares = (
        weights @ gains**2
        - 2 * ratios * (weights @ (gains * sizes[:, None]))
        + ratios**2 * (weights @ sizes**2)[:, None]
    )
    count = len(sizes)
    return ratios, np.sqrt(np.maximum(squares, 0) * count / max(count - 1, 1)) / total


def ranks(names: list[str], pairs: list[Lead]) -> dict[str, Ranks]:
    """The ranks that each detector may have.

    The best is 1 plus the number of those that are certainly better; the worst leaves as many
    behind as are certainly worse (Mogstad, Romano, Shaikh and Wilhelm 2024).

    Args:
        names: All detectors.
        pairs: From `leads`.
    """
    certain = [each for each in pairs if each.is_certain]
    better = {name: sum(each.second == name for each in certain) for name in names}
    worse = {name: sum(each.first == name for each in certain) for name in names}
    return {name: Ranks(1 + better[name], len(names) - worse[name]) for name in names}

"""Compare two detectors while attempts are still being made: a test that allows early looks."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from egad._util.arrays import Flags, Floats
from egad._util.display import facts_html
from egad.bench.stats.paired import match_attempts
from egad.errors import UserError
from egad.random import entropy

BETTER, WORSE = (2, 1), (1, 2)  # beta priors: pseudo-counts of successes and failures


@dataclass(frozen=True, repr=False)
class SequentialTest:
    """Evidence after each pair of attempts that two detectors differ."""

    # e-value after each pair, (n,). If there is no difference, it reaches 1 / level with a
    # probability of at most the level, however often one looks
    e_values: Floats
    level: float
    # pairs after which the e-value first reached 1 / level; None if it has not
    decided_after: int | None
    better: str  # which detector the decision is for: `first` or `second`; empty without one

    @property
    def e_value(self) -> float:
        """The current evidence; 1 means none."""
        return float(self.e_values[-1])

    @property
    def p_value(self) -> float:
        """A p-value that is valid even if one has looked after every pair."""
        return float(min(1.0, 1.0 / self.e_values.max()))

    def __repr__(self) -> str:
        """The decision, and the evidence."""
        facts = "; ".join(f"{name}: {value}" for name, value in self._facts().items())
        return f"SequentialTest({facts})"

    def _repr_html_(self) -> str:
        """The same as a table, for notebooks."""
        return facts_html("Sequential test", self._facts())

    def _facts(self) -> dict[str, object]:
        decision = f"the {self.better} is better, after {self.decided_after} pairs"
        return {
            "decision": decision if self.better else "none yet",
            "pairs": len(self.e_values),
            "e-value": f"{self.e_value:.3g} (needed: {1 / self.level:g})",
            "p-value": f"{self.p_value:.3g}",
        }


def sequential_test(
    first: pd.DataFrame, second: pd.DataFrame, level: float = 0.05, *, one_sided: bool = False
) -> SequentialTest:
    """Test after every pair of attempts whether one detector is better than the other.

    This is the e-process of Turner and Gruenwald (2023) for two streams of successes, see
    `log_e_values`. Stop whenever you like: when it decides, when the time is over, or later than
    planned. The price is more attempts than in a test with a number fixed beforehand.

    The null hypothesis is that in no attempt, given all previous ones, the first is more likely to
    succeed than the second (two-sided: that both are always equally likely to succeed). The two
    attempts of a pair may depend on each other as attempts at one object in one pose do: what makes
    one succeed does not make the other fail. However, attempts at one object are not independent. A
    detector that is better at one shape wins all 20 attempts there, which decides the test,
    correctly, for this shape. To learn which is better on average over objects, try them in random
    order, each once before any of them again. The level then holds while no object is tried twice,
    and roughly for some rounds. In a simulation of 49 objects at which detectors of equal mean
    differed (`ObjectRates`), a detector was found better in 1 % of the cases by the end of 5
    rounds, in 7 % by the end of 20 rounds, and in 50 % with 20 attempts at one object after the
    other. The test of `compare`, which takes objects as the units, holds at the end in any order.

    Args:
        first: Columns label, id, attempt and success, rows in the order of the attempts. An order
            that depends on outcomes would make the test wrong.
        second: The same for the other detector. A pair has the same label and attempt, and counts
            when both its attempts have been made.
        level: Probability of deciding although there is no difference.
        one_sided: Whether only the first can turn out to be better.

    Raises:
        NothingInCommonError: They have no attempt in common.
        UserError: The level is not between 0 and 1, or a label stands for two objects.
    """
    if not 0 < level < 1:
        raise UserError(f"level is {level!r}; allowed: a number above 0 and below 1")
    pairs = match_attempts(first, second)
    one, other = (pairs[f"success_{i}"].to_numpy(dtype=bool) for i in (1, 2))
    forwards, backwards = log_e_values(one, other), log_e_values(other, one)
    values = forwards if one_sided else two_sided(forwards, backwards)
    reached = np.flatnonzero(values >= -np.log(level))
    decided = int(reached[0]) if len(reached) else None
    better = ""
    if decided is not None:
        first_wins = one_sided or forwards[decided] > backwards[decided]
        better = "first" if first_wins else "second"
    with np.errstate(over="ignore"):  # infinite evidence is enough
        e_values = np.exp(values)
    return SequentialTest(e_values, level, None if decided is None else decided + 1, better)


def attempts_in_a_row(table: pd.DataFrame) -> int:
    """The longest run of consecutive attempts at one object; 0 without attempts."""
    labels = table["label"].to_numpy(dtype=str)
    starts = np.flatnonzero(np.append(True, labels[1:] != labels[:-1]))
    return int(np.diff(np.append(starts, len(labels))).max()) if len(labels) else 0


def in_rounds(table: pd.DataFrame) -> pd.DataFrame:
    """Simulated attempts with every object once, in random order, before any again."""
    order = [
        (attempt, entropy(0, "rounds", str(label), int(attempt)))
        for label, attempt in zip(table["label"], table["attempt"], strict=True)
    ]
    return table.iloc[sorted(range(len(order)), key=order.__getitem__)]


def log_e_values(first: Flags, second: Flags) -> Floats:
    """Logarithm of the evidence that the first of two streams, (..., n), succeeds more often.

    Each pair multiplies it by its probability under the posterior means, over that if both rates
    are their midpoint; priors are Beta(2, 1) and Beta(1, 2). Means against the first count as 1.
    """
    better, worse = _rates_before(first, BETTER), _rates_before(second, WORSE)
    middle = (better + worse) / 2
    gains = _log_ratio(first, better, middle) + _log_ratio(second, worse, middle)
    values: Floats = np.where(better > worse, gains, 0.0).cumsum(axis=-1)
    return values


def two_sided(forwards: Floats, backwards: Floats) -> Floats:
    """Logarithm of the mean of two e-values, which is an e-value for either direction."""
    values: Floats = np.logaddexp(forwards, backwards) - np.log(2)
    return values


def _rates_before(successes: Flags, prior: tuple[int, int]) -> Floats:
    """Posterior mean of the success rate before each attempt, (..., n)."""
    before = successes.cumsum(axis=-1) - successes
    rates: Floats = (before + prior[0]) / (np.arange(successes.shape[-1]) + sum(prior))
    return rates


def _log_ratio(successes: Flags, rates: Floats, others: Floats) -> Floats:
    """Logarithm of the probability of each outcome under some rates over that under others."""
    ratios: Floats = np.where(successes, rates / others, (1 - rates) / (1 - others))
    return np.log(ratios)

"""Attempts of a table beside the same attempts simulated again: what arithmetic can explain.

Two processors may round differently. Most contacts keep such a difference as small as it was; a few
amplify it, and the attempt ends otherwise. The same happens if the object is nudged: its inertia is
changed by a few parts in 10^12. So an attempt that ends otherwise than in its table is explained if
a nudged attempt has the same result, and nudged attempts end about as far apart. Else it was
altered.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, fields, replace
from itertools import compress
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.stats import binom

from egad._util.arrays import Flags, Floats, Ints
from egad.sim import Model
from egad.tables.columns import POSE_PARTS

NUDGES = tuple(1e-12 * number for number in range(1, 17))  # relative changes of the inertia
END_TOLERANCE = 1e-6  # metres and parts of a quaternion: less is no other end
SPREAD_RATIO = 10.0  # an end may be this many times as far off as the ends of nudged attempts
# More than the shares of attempts of honest tables (studies/verification/README.md); 99 % of tables
# with such shares are accepted.
UNEXPLAINED_SHARE = 0.004  # of those with other bits: they end otherwise, and nudged ones do not
TURNED_SHARE = 0.05  # of all: they have another result, as nudged ones do
ACCEPTED = 0.99
MAX_SKIPPED = 0.3  # of all attempts
SHOWN = 5  # reasons given for a table
MEASURED = ("lifted", "stopped", *(f"end_{part}" for part in POSE_PARTS))  # those that a table has
RESULTS = ("outcome", "success", "id", "n_objects", "n_present", "present")


class Difference(NamedTuple):
    """A value of a table that the simulation does not reproduce: `said` is that of the table."""

    place: str
    column: str
    said: object
    simulated: object

    def __str__(self) -> str:
        return f"{self.place}: {self.column} is {self.said}, simulated: {self.simulated}"


@dataclass(frozen=True)
class Reproduction:
    """What came of simulating attempts again."""

    attempts: int = 0  # that were compared
    same: int = 0  # to the last bit of what the table has
    close: int = 0  # with the same outcome and end, except for rounding
    explained: tuple[Difference, ...] = ()  # ended otherwise, as nudged ones do
    unexplained: tuple[Difference, ...] = ()  # ended otherwise, and nudged ones do not
    impossible: tuple[Difference, ...] = ()  # contradict seed, settings or table
    skipped: int = 0  # attempts of rounds after one that ended otherwise

    def __add__(self, other: "Reproduction") -> "Reproduction":
        return Reproduction(
            *(getattr(self, each.name) + getattr(other, each.name) for each in fields(self))
        )

    @property
    def is_honest(self) -> bool:
        """Whether other arithmetic explains nearly all differences, and few results differ."""
        different = self.attempts - self.same
        return (
            not self.impossible
            and len(self.unexplained) <= binom.ppf(ACCEPTED, different, UNEXPLAINED_SHARE)
            and len(self.turned) <= binom.ppf(ACCEPTED, self.attempts, TURNED_SHARE)
            and not self.is_cut_short
        )

    @property
    def is_cut_short(self) -> bool:
        """Whether too many attempts follow one that ended otherwise."""
        return self.skipped > MAX_SKIPPED * (self.attempts + self.skipped)

    @property
    def turned(self) -> list[Difference]:
        """Explained differences of results."""
        return [each for each in self.explained if each.column in RESULTS]

    def __str__(self) -> str:
        explained, unexplained = len(self.explained), len(self.unexplained)
        turned = f" ({len(self.turned)} have another result)" if self.turned else ""
        words = [f"{self.same} of {self.attempts} attempts are the same"]
        words += [f"{self.close} except for rounding"] if self.close else []
        if explained:
            words.append(
                f"{explained} differ after a contact, within what other processors give{turned}"
            )
        words += [f"{unexplained} end otherwise without a cause"] if unexplained else []
        words += [f"{self.skipped} after those were not compared"] if self.skipped else []
        return ", ".join(words)

    def reasons(self) -> list[str]:
        """Why the table is refused, the first few; none if it is honest."""
        if self.is_honest:
            return []
        differences = [*self.impossible, *self.unexplained, *self.turned]
        count = len({each.place for each in differences})
        more = [f"and {len(differences) - SHOWN} more"] if len(differences) > SHOWN else []
        reasons = [f"{count} of {self.attempts} attempts are not reproduced"] if count else []
        reasons += [*map(str, differences[:SHOWN]), *more]
        if self.is_cut_short:
            share = f"more than {MAX_SKIPPED:.0%}"
            reasons.append(f"{self.skipped} attempts follow one that ended otherwise, {share}")
        return reasons


def nudged(model: Model, fraction: float) -> Model:
    """An object whose inertia differs by a fraction, so that arithmetic differs after a contact."""
    return replace(model, inertia=model.inertia * (1 + fraction))


def judge(
    said: pd.DataFrame,
    simulated: pd.DataFrame,
    places: Sequence[str],
    simulate_nudged: Callable[[float, Ints], pd.DataFrame],
) -> Reproduction:
    """Compare rows of a table with the same rows simulated again, each from its own beginning.

    `simulate_nudged` does so for some of them, by number, with the object nudged by a fraction.
    """
    distances, have_same_results = _distances(said, simulated), _same_results(said, simulated)
    departed = _departed(have_same_results, distances)
    spread, seen = np.zeros(len(departed)), have_same_results[departed]
    is_explained = np.zeros(len(departed), dtype=np.bool_)
    for fraction in NUDGES:
        left = np.flatnonzero(~is_explained)
        if not len(left):
            break
        rows = departed[left]
        others = simulate_nudged(fraction, rows)
        spread[left] = np.maximum(spread[left], _distances(simulated.iloc[rows], others))
        seen[left] |= _same_results(said.iloc[rows], others)
        is_explained = seen & (distances[departed] <= SPREAD_RATIO * spread)
    differences = [
        _difference(said.iloc[row], simulated.iloc[row], places[row]) for row in departed.tolist()
    ]
    same = int(((distances == 0) & have_same_results).sum())
    return Reproduction(
        attempts=len(said),
        same=same,
        close=len(said) - len(departed) - same,
        explained=tuple(compress(differences, is_explained)),
        unexplained=tuple(compress(differences, ~is_explained)),
    )


def first_departure(said: pd.DataFrame, simulated: pd.DataFrame) -> int | None:
    """Number of the first row that ended otherwise; None if there is none."""
    departed = _departed(_same_results(said, simulated), _distances(said, simulated))
    return next(iter(departed.tolist()), None)


def differing(
    rows: pd.DataFrame, determined: pd.DataFrame, places: Sequence[str]
) -> Iterator[Difference]:
    """Values of rows that differ from those of the same rows that are determined beforehand."""
    for column in determined:
        expected = determined[column].to_numpy()
        for number in np.flatnonzero(rows[column].to_numpy() != expected).tolist():
            yield Difference(places[number], str(column), rows[column][number], expected[number])


def _departed(have_same_results: Flags, distances: Floats) -> Ints:
    """Numbers of the rows that ended otherwise."""
    return np.flatnonzero(~have_same_results | (distances > END_TOLERANCE))


def _same_results(first: pd.DataFrame, second: pd.DataFrame) -> Flags:
    same = np.ones(len(first), dtype=np.bool_)
    for column in (each for each in RESULTS if each in second):
        same &= first[column].to_numpy() == second[column].to_numpy()
    return same


def _distances(first: pd.DataFrame, second: pd.DataFrame) -> Floats:
    """By how much each row ends otherwise, metres or parts of a quaternion."""
    distances = np.zeros(len(first))
    for column in (each for each in MEASURED if each in second):
        distances = np.maximum(distances, _shift(first[column], second[column]))
    return distances


def _shift(first: pd.Series, second: pd.Series) -> Floats:
    """Absolute differences; 0 of two that are missing, infinite of one."""
    one, two = first.to_numpy(np.float64), second.to_numpy(np.float64)
    shift = np.where(np.isnan(one) & np.isnan(two), 0.0, np.abs(one - two))
    return np.nan_to_num(shift, nan=np.inf)


def _difference(said: pd.Series, simulated: pd.Series, place: str) -> Difference:
    """The first difference of the results of two rows, or else the largest of what was measured."""
    columns = [each for each in RESULTS if each in simulated and said[each] != simulated[each]]
    if not columns:
        known = [each for each in MEASURED if each in simulated]
        shifts = _shift(said[known], simulated[known])
        columns = [known[int(shifts.argmax())]]
    return Difference(place, columns[0], said[columns[0]], simulated[columns[0]])

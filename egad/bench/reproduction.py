"""Attempts of a table beside the same attempts simulated again: what arithmetic can explain.

Two processors may round differently. Most contacts keep such a difference as small as it was; a few
amplify it, and the attempt ends otherwise. The same happens if the object is nudged: its inertia is
changed by a few parts in 10^12. So an attempt that ends otherwise than in its table is explained if
nudged attempts differ among themselves about as much, and else it was altered.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from itertools import compress
from typing import NamedTuple

import numpy as np
import pandas as pd

from egad._util.arrays import Floats, Ints
from egad.sim import Model
from egad.tables.columns import POSE_PARTS

NUDGES = tuple(1e-12 * number for number in range(1, 9))  # relative changes of the inertia
CLOSE = 1e-6  # metres and parts of a quaternion: less is no other end
# An end is explained if nudges move it by a part of its distance, or by some metres.
AMPLE, CHAOTIC = 10.0, 1e-3
OTHER = 1.0  # distance of two ends with other results
# Of the attempts that are not the same to the last bit, at most this share may be unexplained: more
# than honest tables have (docs/leaderboard.md).
MAX_UNEXPLAINED = 0.01
SHOWN = 5  # reasons given for a table
MEASURED = ("lifted", "stopped", *(f"end_{part}" for part in POSE_PARTS))  # those that a table has
RESULTS = ("outcome", "success", "id", "n_present", "present")


class Difference(NamedTuple):
    """A value of a table that the simulation does not reproduce: `said` is that of the table."""

    place: str
    column: str
    said: object
    found: object

    def __str__(self) -> str:
        return f"{self.place}: {self.column} is {self.said}, simulated: {self.found}"


@dataclass(frozen=True)
class Reproduction:
    """What came of simulating attempts again."""

    attempts: int = 0  # that were compared
    same: int = 0  # to the last bit
    close: int = 0  # with the same outcome and end, but for rounding
    explained: tuple[Difference, ...] = ()  # ended otherwise, as nudged ones do
    unexplained: tuple[Difference, ...] = ()  # ended otherwise, and nudged ones do not
    impossible: tuple[Difference, ...] = ()  # contradict seed, settings or table
    unchecked: int = 0  # attempts of rounds after one that ended otherwise

    def __add__(self, other: "Reproduction") -> "Reproduction":
        return Reproduction(
            *(getattr(self, each.name) + getattr(other, each.name) for each in fields(self))
        )

    @property
    def is_honest(self) -> bool:
        """Whether other arithmetic explains all differences but for a few."""
        most = MAX_UNEXPLAINED * (self.attempts - self.same)
        return not self.impossible and len(self.unexplained) <= most

    def __str__(self) -> str:
        explained, unexplained = len(self.explained), len(self.unexplained)
        words = [f"{self.same} of {self.attempts} attempts are the same to the last bit"]
        words += [f"{self.close} but for rounding"] if self.close else []
        if explained:
            words.append(f"{explained} differ after a contact, within what other processors give")
        words += [f"{unexplained} end otherwise without a cause"] if unexplained else []
        words += [f"{self.unchecked} were not compared"] if self.unchecked else []
        return ", ".join(words)

    def reasons(self) -> list[str]:
        """Why the table is refused, the first few; none if it is honest."""
        if self.is_honest:
            return []
        differences = [*self.impossible, *self.unexplained]
        count = len({each.place for each in differences})
        more = [f"and {len(differences) - SHOWN} more"] if len(differences) > SHOWN else []
        return [
            f"{count} of {self.attempts} attempts are not reproduced",
            *map(str, differences[:SHOWN]),
            *more,
        ]


def nudged(model: Model, by: float) -> Model:
    """An object whose inertia differs by a fraction, so that arithmetic differs after a contact."""
    return replace(model, inertia=model.inertia * (1 + by))


def judge(
    said: pd.DataFrame,
    found: pd.DataFrame,
    places: Sequence[str],
    nudged: Callable[[float, Ints], pd.DataFrame],
) -> Reproduction:
    """Compare rows of a table with the same rows simulated again, each from its own beginning.

    `nudged` simulates some of them, by number, with the object nudged by a fraction.
    """
    distances = _distances(said, found)
    away = np.flatnonzero(distances > CLOSE)
    spread = np.zeros(len(away))
    for by in NUDGES if len(away) else ():
        spread = np.maximum(spread, _distances(found.iloc[away], nudged(by, away)))
    is_explained = spread >= np.minimum(distances[away] / AMPLE, CHAOTIC)
    differences = [
        _difference(said.iloc[row], found.iloc[row], places[row]) for row in away.tolist()
    ]
    return Reproduction(
        attempts=len(said),
        same=int((distances == 0).sum()),
        close=int(((distances > 0) & (distances <= CLOSE)).sum()),
        explained=tuple(compress(differences, is_explained)),
        unexplained=tuple(compress(differences, ~is_explained)),
    )


def first_departure(said: pd.DataFrame, found: pd.DataFrame) -> int | None:
    """Number of the first row that ended otherwise; None if there is none."""
    return next(iter(np.flatnonzero(_distances(said, found) > CLOSE).tolist()), None)


def _distances(first: pd.DataFrame, second: pd.DataFrame) -> Floats:
    """By how much each row ends otherwise, metres or parts of a quaternion; `OTHER` by result."""
    distances = np.zeros(len(first))
    for column in (each for each in MEASURED if each in second):
        one, two = (table[column].to_numpy(np.float64) for table in (first, second))
        shift = np.where(np.isnan(one) & np.isnan(two), 0.0, np.abs(one - two))
        distances = np.maximum(distances, np.nan_to_num(shift, nan=OTHER))
    for column in (each for each in RESULTS if each in second):
        distances[first[column].to_numpy() != second[column].to_numpy()] = OTHER
    return distances


def _difference(said: pd.Series, found: pd.Series, place: str) -> Difference:
    """The first difference of two rows: of their results, or else of what was measured."""
    for column in (each for each in (*RESULTS, *MEASURED) if each in found):
        one, two = said[column], found[column]
        if one != two and not (pd.isna(one) and pd.isna(two)):
            return Difference(place, column, one, two)
    raise AssertionError("the rows are the same")

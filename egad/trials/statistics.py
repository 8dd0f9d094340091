"""Success rates with their uncertainty, and the grid that they are shown in."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.stats import binomtest


def wilson(successes: int, attempts: int, confidence: float = 0.95) -> tuple[float, float]:
    """Wilson's score interval of a success probability (Wilson 1927).

    Args:
        successes: How often it worked.
        attempts: How often it was tried.
        confidence: Of the two-sided interval.

    Returns:
        Lower and upper end; 0 and 1 without attempts, when nothing is known.
    """
    if attempts == 0:
        return 0.0, 1.0
    found = binomtest(successes, attempts).proportion_ci(confidence, method="wilson")
    return float(found.low), float(found.high)


@dataclass(frozen=True)
class Rate:
    """How often something worked."""

    successes: int
    attempts: int

    @property
    def value(self) -> float:
        """Successes / attempts; NaN if there were no attempts."""
        return self.successes / self.attempts if self.attempts else float("nan")

    @property
    def interval(self) -> tuple[float, float]:
        """Lower and upper end of the Wilson interval of 95 %."""
        return wilson(self.successes, self.attempts)


@dataclass(frozen=True)
class TrialGrid:
    """Success rates over the grid of the evaluation set, row 0 = easiest, column 0 = simplest.

    Attributes:
        cells: By row and column, of the objects that there are.
        rows: Over all attempts of each row; the mean of its objects, which are all tried equally.
        columns: The same of each column.
        overall: Over all attempts.
    """

    cells: dict[tuple[int, int], Rate]
    rows: list[Rate]
    columns: list[Rate]
    overall: Rate


def rate(trials: pd.DataFrame) -> Rate:
    """The success rate over all rows of a table of attempts."""
    return Rate(int(trials["success"].sum()), len(trials))


def trial_grid(trials: pd.DataFrame, rows: int, columns: int) -> TrialGrid:
    """Success rate of every object, row and column of the evaluation set, as in the paper.

    Args:
        trials: Columns `label` (such as C4) and `success`, one row an attempt.
        rows: Letters of the set.
        columns: Digits of the set.
    """
    places = [(ord(label[0]) - ord("A"), int(label[1:])) for label in trials["label"]]
    row, column = np.array(places, dtype=np.int64).reshape(-1, 2).T
    cells = {
        place: rate(trials[(row == place[0]) & (column == place[1])])
        for place in sorted(set(places))
    }
    return TrialGrid(
        cells,
        [rate(trials[row == index]) for index in range(rows)],
        [rate(trials[column == index]) for index in range(columns)],
        rate(trials),
    )

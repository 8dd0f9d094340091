"""Intervals and grids of success rates."""

import math

import numpy as np
import pandas as pd
import pytest

from egad.trials.statistics import Rate, rate, trial_grid, wilson

TRIALS = pd.DataFrame(
    [("A0", True)] * 20 + [("A2", True)] * 5 + [("A2", False)] * 15 + [("C2", False)] * 20,
    columns=["label", "success"],
)


@pytest.mark.parametrize(("successes", "attempts"), [(0, 20), (7, 20), (20, 20), (58, 100)])
def test_the_ends_are_where_the_score_test_just_rejects(successes: int, attempts: int) -> None:
    """The definition: |p - x / n| = z sqrt(p (1 - p) / n)."""
    z = 1.959963984540054
    for end in wilson(successes, attempts):
        distance = abs(end - successes / attempts)
        assert distance == pytest.approx(z * math.sqrt(end * (1 - end) / attempts), abs=1e-7)


def test_known_intervals() -> None:
    assert wilson(10, 20) == pytest.approx((0.2993, 0.7007), abs=1e-4)
    low, high = wilson(0, 20)
    assert low == 0
    assert high == pytest.approx(0.1611, abs=1e-4)


def test_intervals_cover_as_often_as_they_say() -> None:
    """Exact coverage over all outcomes of 20 attempts, averaged over true rates."""
    chosen = [math.comb(20, k) for k in range(21)]
    ends = [wilson(k, 20, 0.9) for k in range(21)]
    coverage = [
        sum(
            c * p**k * (1 - p) ** (20 - k)
            for k, (c, (low, high)) in enumerate(zip(chosen, ends, strict=True))
            if low <= p <= high
        )
        for p in np.linspace(0.05, 0.95, 181)
    ]
    assert np.mean(coverage) == pytest.approx(0.9, abs=0.02)


def test_without_attempts_nothing_is_known() -> None:
    assert wilson(0, 0) == (0.0, 1.0)
    assert math.isnan(Rate(0, 0).value)
    assert rate(TRIALS[:0]) == Rate(0, 0)


def test_the_grid_has_the_objects_and_the_means() -> None:
    grid = trial_grid(TRIALS, 7, 7)
    assert grid.cells == {(0, 0): Rate(20, 20), (0, 2): Rate(5, 20), (2, 2): Rate(0, 20)}
    assert grid.rows[0] == Rate(25, 40)
    assert grid.rows[1] == Rate(0, 0)
    assert grid.columns[2] == Rate(5, 40)
    assert grid.overall == Rate(25, 60)
    assert (len(grid.rows), len(grid.columns)) == (7, 7)


def test_a_row_is_the_mean_of_its_equally_tried_objects() -> None:
    grid = trial_grid(TRIALS, 7, 7)
    assert grid.rows[0].value == pytest.approx(np.mean([1.0, 0.25]))


def test_an_empty_grid() -> None:
    grid = trial_grid(TRIALS[:0], 7, 7)
    assert grid.cells == {}
    assert all(part.attempts == 0 for part in (*grid.rows, *grid.columns, grid.overall))

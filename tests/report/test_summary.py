import math

import numpy as np
import pandas as pd
import pytest

from egad.report import summary
from egad.report.data import DatasetReport


def test_interval_is_wilsons():
    successes, attempts, z = 568, 980, 1.959963984540054
    share = successes / attempts
    centre = (share + z**2 / (2 * attempts)) / (1 + z**2 / attempts)
    half = z / (1 + z**2 / attempts)
    half *= math.sqrt(share * (1 - share) / attempts + z**2 / (4 * attempts**2))
    low, high = summary.Rate(successes, attempts).interval
    assert (low, high) == pytest.approx((centre - half, centre + half))


def test_a_rate_without_attempts_says_nothing():
    nothing = summary.Rate(0, 0)
    assert math.isnan(nothing.value)
    assert nothing.interval == (0, 1)


def test_trial_grid_counts_each_attempt_once():
    random = np.random.default_rng(0)
    names = [f"{letter}{digit}" for letter in "ABC" for digit in range(4)]
    trials = pd.DataFrame({"label": random.choice(names, 200), "success": random.random(200) < 0.4})
    grid = summary.trial_grid(trials, 3, 4)
    for (row, column), rate in grid.cells.items():
        wanted = trials[trials["label"] == f"{'ABC'[row]}{column}"]["success"]
        assert (rate.successes, rate.attempts) == (wanted.sum(), len(wanted))
    assert sum(rate.attempts for rate in grid.rows) == 200
    assert sum(rate.attempts for rate in grid.columns) == 200
    second = trials[trials["label"].str.startswith("B")]["success"]
    assert grid.rows[1].value == pytest.approx(second.mean())
    assert grid.overall.successes == trials["success"].sum()


def test_trial_grid_of_untried_rows(trials):
    grid = summary.trial_grid(trials, 7, 7)
    assert grid.cells[0, 0].value == 0.75
    assert grid.rows[6].attempts == 0
    assert (6, 6) not in grid.cells


def test_published_coverage_is_of_places():
    theirs = summary.PUBLISHED.set_index("dataset").loc["EGAD, 2020"]
    assert theirs["coverage"] == pytest.approx(theirs["objects"] / 2500, abs=0.005)


def test_grasp_numbers(grasps):
    found = summary.grasp_numbers("yumi", grasps)
    assert (found["objects"], found["grasps"], found["per_object"]) == (40, 400, 10)
    assert found["collision_free"] == 0.25
    assert found["quality"][1] == pytest.approx(grasps["quality"].median())


def test_scale_numbers_of_what_is_there(report):
    found = summary.scale_numbers("egad_75mm", report.datasets["egad"])
    assert (found["scaled"]["objects"], found["scaled"]["changed"]) == (40, 10)
    assert found["scaled"]["factor"] == pytest.approx([0.8, 1, 1])
    assert found["printed"] == {"objects": 3, "plates": 2, "too_large": ["G6"]}
    bare = DatasetReport(report.datasets["egad"].objects, report.datasets["egad"].rejected)
    assert summary.scale_numbers("yumi", bare)["scaled"] is None


def test_rejections_and_outcomes_are_ordered_by_frequency(report, trials):
    counts = summary.rejection_counts(report.datasets["egad"].rejected)
    assert [row["count"] for row in counts] == [2, 1]
    assert counts[0]["reason"] == "no volume"
    assert summary.outcome_counts(trials) == {
        "success": 15,
        "missed": 12,
        "no_grasp": 8,
        "slipped": 5,
    }
    assert next(iter(summary.outcome_counts(trials))) == "success"

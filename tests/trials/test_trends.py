import numpy as np
import pandas as pd
import pytest
from scipy.stats import spearmanr

from egad.trials.trends import places, trend


def test_the_coefficient_is_that_of_scipy():
    rng = np.random.default_rng(0)
    values, rates = rng.random(49), rng.integers(0, 21, 49) / 20
    assert trend(values, rates).rho == pytest.approx(spearmanr(values, rates)[0])


def test_the_interval_covers_as_often_as_it_says():
    """Of a bivariate normal distribution the rank correlation is known."""
    rng = np.random.default_rng(1)
    linear = 0.6
    truth = 6 / np.pi * np.arcsin(linear / 2)
    held = 0
    for _ in range(30):
        x = rng.normal(size=49)
        y = linear * x + (1 - linear**2) ** 0.5 * rng.normal(size=49)
        found = trend(x, y)
        held += found.low <= truth <= found.high
    assert held >= 25


def test_the_same_rate_everywhere_has_no_trend():
    found = trend(np.arange(9.0), np.ones(9))
    assert np.isnan([found.rho, found.low, found.high]).all()
    assert np.isnan(trend(np.array([]), np.array([])).rho)


TRIALS = pd.DataFrame({"label": ["A0", "A0", "C4", "G6"], "success": [True, False, True, False]})


def test_labels_tell_the_place_where_nothing_else_does():
    found = places(TRIALS)
    assert found.loc["C4"].to_dict() == {"rate": 1.0, "difficulty": 2.0, "complexity": 4.0}
    assert found.loc["A0", "rate"] == 0.5


def test_the_evaluation_set_tells_more():
    """A high grasp quality is easy, so hard objects come out on top."""
    evalset = pd.DataFrame(
        {
            "label": ["G6", "A0", "C4"],
            "difficulty": [0.001, 0.004, 0.003],
            "complexity": [4.5, 1.2, 3.0],
        }
    )
    found = places(TRIALS, evalset)
    assert found.index.tolist() == ["A0", "C4", "G6"]
    assert found["difficulty"].tolist() == [-0.004, -0.003, -0.001]
    assert found["complexity"].tolist() == [1.2, 3.0, 4.5]
    assert places(TRIALS, evalset[:2]).equals(places(TRIALS))

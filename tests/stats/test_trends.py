import numpy as np
import pandas as pd
import pytest
from scipy.stats import spearmanr

from egad.stats import rates as statistics
from egad.stats.rates import places, trend


def test_the_coefficient_is_that_of_scipy():
    rng = np.random.default_rng(0)
    values, rates = rng.random(49), rng.integers(0, 21, 49) / 20
    assert trend(values, rates).rho == pytest.approx(spearmanr(values, rates)[0])


@pytest.mark.parametrize("linear", [0.0, 0.6])
def test_the_interval_covers_as_often_as_it_says(linear, monkeypatch):
    """Of a bivariate normal distribution the rank correlation is known (Pearson 1907).

    Of 400 samples the interval of 95 % holds it in 380, give or take 4.4: the bounds are further
    off than three of these, and leave out an interval of 90 % and one of 99 %.
    """
    monkeypatch.setattr(statistics, "DRAWS", 1000)
    rng = np.random.default_rng(1)
    truth = 6 / np.pi * np.arcsin(linear / 2)
    below = above = 0
    for _ in range(400):
        x = rng.normal(size=49)
        found = trend(x, linear * x + (1 - linear**2) ** 0.5 * rng.normal(size=49))
        below, above = below + (truth < found.low), above + (truth > found.high)
    assert 366 <= 400 - below - above <= 394
    assert max(below, above) <= 20


def test_only_ranks_count():
    rng = np.random.default_rng(2)
    x, y = rng.normal(size=(2, 30))
    assert trend(np.exp(x), y**3) == trend(x, y)
    turned = trend(x, -y)
    assert (turned.rho, turned.low) == pytest.approx(
        (-trend(x, y).rho, -trend(x, y).high), abs=0.03
    )


def test_a_perfect_order_is_certain():
    found = trend(np.arange(9.0), np.arange(9.0) ** 2)
    assert (found.rho, found.low, found.high) == pytest.approx((1.0, 1.0, 1.0))


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

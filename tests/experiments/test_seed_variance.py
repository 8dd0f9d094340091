"""The number of networks that shows a difference, against other ways to find it."""

import runpy
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

STUDY = Path(__file__).parents[2] / "experiments/training_study"


@pytest.fixture(scope="module")
def power():
    """The simulation of the power, with few repeats."""
    program = runpy.run_path(str(STUDY / "seed_variance.py"))
    program["share"].__globals__["REPEATS"] = 400
    return program


def test_equal_sets_seem_to_differ_in_a_twentieth_of_the_cases(power):
    for networks in (3, 8):
        assert power["share"](0.02, 49, networks, 0.0, 0.05) == pytest.approx(0.05, abs=0.035)


def test_power_is_that_of_the_noncentral_t_distribution(power):
    """The twin: Student's test, with the chance of the attempts added to the variance."""
    objects, networks, spread, gain = 49, 6, 0.02, 0.05
    easy = power["generator"](0, "objects", objects).beta(2, 2, objects)
    chance = np.mean(easy * (1 - easy)) / (objects * power["ATTEMPTS"])
    shift = gain / np.sqrt(2 * (spread**2 + chance) / networks)
    freedom = 2 * networks - 2
    limit = stats.t.ppf(0.975, freedom)
    expected = stats.nct.sf(limit, freedom, shift) + stats.nct.cdf(-limit, freedom, shift)
    assert power["share"](spread, objects, networks, gain, 0.05) == pytest.approx(
        expected, abs=0.06
    )


@pytest.mark.parametrize(("limit", "found"), [(5, 4), (30, 24), (90, 60)])
def test_the_first_number_with_enough_power_is_found(power, limit, found):
    assert power["first"](range(3, 60), lambda number: number / limit) == found

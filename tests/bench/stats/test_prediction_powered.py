"""Intervals with the help of a simulation: what they hold, gain, and lose."""

from functools import lru_cache

import numpy as np
import pytest

from egad.bench.stats import ObjectRates, prediction_powered_rate
from egad.errors import UserError


@lru_cache
def true_rates(correlation):
    return ObjectRates(0.6, 0.3, correlation)


def rates(correlation, both, simulated_only, rng, attempts=20, worse=0.2):
    """Real rates of few attempts, and simulated ones of many that are too high on average."""
    simulated, real = true_rates(correlation).sample((both + simulated_only,), worse, rng)
    real = rng.binomial(attempts, real[:both]) / attempts
    simulated = rng.binomial(200, simulated) / 200
    return real, simulated[:both], simulated[both:]


def many(correlation, both, simulated_only, runs=600, attempts=20):
    rng = np.random.default_rng(0)
    return [
        prediction_powered_rate(*rates(correlation, both, simulated_only, rng, attempts))
        for _ in range(runs)
    ]


@pytest.mark.parametrize("correlation", [0.0, 0.6, 0.95])
@pytest.mark.parametrize(("both", "simulated_only"), [(6, 43), (15, 34), (30, 500)])
def test_the_interval_holds_the_true_mean_although_the_simulation_is_too_easy(
    correlation, both, simulated_only
):
    found = many(correlation, both, simulated_only)
    held = np.mean([each.interval[0] <= 0.5 <= each.interval[1] for each in found])
    assert held >= 0.95 - 3 * np.sqrt(0.05 * 0.95 / 600)
    errors = np.array([each.value - 0.5 for each in found])
    assert abs(errors.mean()) < 0.2 * errors.std()


def test_the_gain_grows_with_correlation_and_there_is_none_without():
    """It is 1 / (1 - r^2 m / (n + m)), with r of the measured rates: 20 attempts are noise."""
    none, some, much = (many(each, 49, 2000, 200) for each in (0.0, 0.7, 0.95))
    middle = [np.median([each.gain for each in found]) for found in (none, some, much)]
    assert middle[0] == pytest.approx(1, abs=0.03)
    assert 1.3 < middle[1] < 1.96
    assert middle[2] > 2.5
    measured = np.median([each.correlation for each in much])
    assert middle[2] == pytest.approx(1 / (1 - measured**2 * 2000 / 2049), rel=0.08)


def test_a_simulation_that_is_wrong_the_other_way_round_is_ignored():
    rng = np.random.default_rng(0)
    real, simulated, more = rates(0.9, 30, 200, rng)
    found = prediction_powered_rate(real, 1 - simulated, 1 - more)
    assert (found.weight, found.gain, found.value) == (0, 1, real.mean())
    assert found.interval == found.plain_interval
    assert found.correlation < 0


def test_nothing_is_gained_from_the_same_objects():
    real, simulated, _ = rates(0.9, 30, 0, np.random.default_rng(0))
    found = prediction_powered_rate(real, simulated, np.array([]))
    assert (found.weight, found.gain) == (0, 1)
    assert found.interval == found.plain_interval
    assert (found.both, found.simulated_only) == (30, 0)


def test_the_weight_makes_up_for_objects_that_happen_to_be_hard():
    """An exact simulation: the mean of all objects is found from the hard half of them."""
    simulated = np.linspace(0.1, 0.4, 10)
    found = prediction_powered_rate(simulated - 0.05, simulated, np.linspace(0.5, 0.9, 10))
    assert found.value == pytest.approx(np.mean([*simulated, *np.linspace(0.5, 0.9, 10)]) - 0.05)
    assert found.weight == pytest.approx(0.5)
    assert found.plain == pytest.approx(0.2)
    assert "success rate: 42.5 % (95 % interval " in repr(found)


def test_rates_that_are_all_equal_have_no_interval():
    found = prediction_powered_rate(np.ones(9), np.linspace(0, 1, 9), np.linspace(0, 1, 20))
    assert found.value == 1
    assert np.isnan([*found.interval, *found.plain_interval, found.correlation]).all()
    assert "100.0 % (no interval)" in repr(found)
    constant = prediction_powered_rate(np.linspace(0, 1, 9), np.ones(9), np.ones(20))
    assert (constant.value, constant.gain) == (0.5, 1)


def test_intervals_end_at_nothing_and_at_all():
    real = np.array([1.0] * 8 + [0.9])
    found = prediction_powered_rate(real, real, np.linspace(0.9, 1, 50))
    assert found.interval[0] < found.value <= found.interval[1] <= 1


def test_too_few_objects_are_told():
    with pytest.raises(UserError, match="4 objects have real and simulated attempts; at least 5"):
        prediction_powered_rate(np.ones(4), np.ones(4), np.ones(20))

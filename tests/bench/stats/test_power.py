"""Planned numbers of attempts: they have the power they promise, and the rates they are told."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from egad.bench.stats import ObjectRates, compare, fit_object_rates, plan_attempts, sequential_test
from egad.errors import UserError

EASY = ObjectRates(0.6, 0.2, 0.9)


def tables(one, other, attempts, rng, *, rounds=False):
    """Attempts of two detectors with these rates of objects, and their labels."""
    labels = np.repeat([f"{'ABCDEFGHIJ'[i // 10]}{i % 10}" for i in range(len(one))], attempts)
    numbers = np.tile(np.arange(attempts), len(one))
    order = np.lexsort((rng.random(len(labels)), numbers)) if rounds else slice(None)
    frame = pd.DataFrame({"label": labels, "id": "", "attempt": numbers, "initial_pose": ""})
    return [
        frame.assign(success=rng.random(len(labels)) < np.repeat(rates, attempts)).iloc[order]
        for rates in (one, other)
    ]


def test_the_planned_attempts_have_their_power_in_whole_comparisons(monkeypatch):
    """Tables of attempts, through `compare`: independent of how the plan counts them."""
    monkeypatch.setattr("egad.bench.stats.rates.DRAWS", 10)  # intervals are not looked at
    plan = plan_attempts(30, EASY, difference=0.15)
    rng = np.random.default_rng(1)
    won = 0
    for _ in range(120):
        one, other = EASY.sample((30,), 0.15, rng)
        found = compare(*tables(one, other, plan.attempts, rng))
        won += found.p_objects <= 0.05 and found.difference > 0
    assert won / 120 == pytest.approx(plan.power, abs=3 * np.sqrt(0.16 / 120))
    assert plan.power >= 0.8


def test_the_sequential_test_stops_when_the_plan_says():
    plan = plan_attempts(10, EASY, difference=0.3)
    rng = np.random.default_rng(1)
    stops = []
    for _ in range(150):
        pair = tables(*EASY.sample((10,), 0.3, rng), 100, rng, rounds=True)
        found = sequential_test(*pair)
        stops.append(found.decided_after if found.better == "first" else np.inf)
    assert np.mean(np.array(stops) <= plan.sequential) == pytest.approx(0.8, abs=0.1)
    assert np.mean(np.array(stops) <= plan.median) == pytest.approx(0.5, abs=0.12)


def test_attempts_cannot_make_up_for_too_few_objects():
    """Five objects cannot differ significantly: at best, p = 2 / 2^5."""
    plan = plan_attempts(5, EASY, difference=0.3)
    assert (plan.attempts, plan.power) == (None, 0)
    varied = plan_attempts(12, replace(EASY, correlation=0.0, spread=0.35))
    assert varied.attempts is None
    assert varied.power < 0.5


def test_the_test_over_objects_is_wrong_as_rarely_as_its_level_says():
    """A difference that is nothing in effect: either detector is found in 2.5 % of the cases."""
    plan = plan_attempts(30, ObjectRates(), difference=1e-9, most=5, runs=1000)
    assert plan.attempts is None
    assert plan.power == pytest.approx(0.025, abs=0.015)


def test_a_plan_is_the_same_each_time():
    one, other = (plan_attempts(9, EASY, difference=0.3, runs=50, most=20) for _ in range(2))
    assert one == other


def test_sampled_rates_have_the_moments_they_are_told():
    one, other = ObjectRates(0.6, 0.25, 0.7).sample((40_000,), 0.1, np.random.default_rng(0))
    assert (one - other).mean() == pytest.approx(0.1, abs=0.005)
    assert one.std() == pytest.approx(0.25, abs=0.01)
    assert np.corrcoef(one, other)[0, 1] == pytest.approx(0.7, abs=0.01)
    assert min(one.min(), other.min()) >= 0
    assert max(one.max(), other.max()) <= 1
    one, other = ObjectRates(0.8, 0.36, 0.7).sample((40_000,), 1e-6, np.random.default_rng(0))
    assert np.corrcoef(one, other)[0, 1] == pytest.approx(0.7, abs=0.01)  # rates near 0 and 1
    same = ObjectRates(0.6, 0.0).sample((5,), 0.1, np.random.default_rng(0))
    assert np.unique(same) == pytest.approx([0.55, 0.65])


def test_rates_of_tables_are_found_again_without_the_noise_of_few_attempts():
    """Rates of four attempts have a standard deviation of 0.30 here, the true ones of 0.2."""
    rng = np.random.default_rng(0)
    truth = ObjectRates(0.6, 0.2, 0.8)
    found = [fit_object_rates(tables(*truth.sample((100,), 0.0, rng), 4, rng)) for _ in range(20)]
    assert np.mean([each.mean for each in found]) == pytest.approx(0.6, abs=0.02)
    assert np.mean([each.spread for each in found]) == pytest.approx(0.2, abs=0.02)
    assert np.mean([each.correlation for each in found]) == pytest.approx(0.8, abs=0.07)


def test_one_table_says_nothing_about_correlation():
    rng = np.random.default_rng(0)
    first, _ = tables(*EASY.sample((40,), 0.0, rng), 10, rng)
    assert fit_object_rates([first]).correlation == ObjectRates().correlation
    alike = tables(np.full(9, 0.5), np.full(9, 0.5), 2, np.random.default_rng(4))
    assert 0 <= fit_object_rates(alike).correlation <= 1


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (
            {"difference": 0},
            "the difference is 0 percentage points; allowed for a mean of 60 %: above 0, bel",
        ),
        ({"most": 0}, "most is 0; allowed: a whole number, at least 1"),
    ],
)
def test_wrong_numbers_are_named(arguments, words):
    with pytest.raises(UserError, match=words):
        plan_attempts(**{"objects": 10, "rates": EASY} | arguments)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((0.0, 0.1, 0.5), "the mean rate is 0 %; allowed: above 0 and below 100 %"),
        (
            (0.5, 0.5, 0.5),
            "the rates vary by 50 percentage points; allowed for a mean of 50 %: .*, below 50",
        ),
        ((0.5, 0.1, 1.1), "the correlation is 1.1; allowed: 0 to 1"),
    ],
)
def test_impossible_rates_are_named(arguments, words):
    with pytest.raises(UserError, match=words):
        ObjectRates(*arguments)


def test_tables_that_say_nothing_about_objects_are_refused():
    once = pd.DataFrame({"label": ["A0", "A1"], "success": [True, False]})
    with pytest.raises(UserError, match="at least two objects with two attempts each"):
        fit_object_rates([once])
    never = pd.DataFrame({"label": ["A0", "A0", "A1", "A1"], "success": False})
    with pytest.raises(UserError, match="the mean rate is 0 %"):
        fit_object_rates([never])

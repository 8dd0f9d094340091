import numpy as np
import pandas as pd
import pytest

from egad.stats.rates import Rate
from egad.stats.roc import discrimination, reliability


def table(quality, success):
    return pd.DataFrame({"quality": quality, "success": success})


def test_a_quality_that_is_the_chance_of_success_lies_on_the_diagonal():
    rng = np.random.default_rng(0)
    quality = rng.random(20_000)
    bins = reliability(table(quality, rng.random(20_000) < quality))
    assert len(bins) == 10
    for each in bins:
        low, high = each.rate.interval
        assert low - 0.01 < each.quality < high + 0.01
        assert each.rate.attempts == pytest.approx(2000, abs=1)


def test_attempts_without_a_quality_are_left_out():
    found = reliability(table([np.nan, 0.2, 0.2, np.inf], [False, True, False, True]))
    assert [(each.quality, each.rate) for each in found] == [(0.2, Rate(1, 2))]
    assert reliability(table([np.nan], [False])) == []
    assert reliability(table([], [])) == []


def test_equal_qualities_stay_together():
    quality = [0.0] * 50 + [1.0] * 3
    found = reliability(table(quality, [False] * 50 + [True] * 3))
    assert [(each.quality, each.rate) for each in found] == [(0, Rate(0, 50)), (1, Rate(3, 3))]


def test_every_attempt_is_in_one_bin():
    rng = np.random.default_rng(1)
    for count in (1, 2, 9, 10, 11, 57):
        found = reliability(table(rng.random(count), rng.random(count) < 0.5))
        assert sum(each.rate.attempts for each in found) == count
        assert sorted(each.quality for each in found) == [each.quality for each in found]


def test_discrimination_is_the_part_of_pairs_in_the_right_order():
    rng = np.random.default_rng(2)
    quality, success = rng.integers(0, 8, 60) / 8, rng.random(60) < 0.4
    pairs = quality[success][:, None] - quality[~success][None]
    slow = ((pairs > 0) + 0.5 * (pairs == 0)).mean()
    assert discrimination(table(quality, success)) == pytest.approx(slow)


def test_discrimination_of_the_perfect_the_blind_and_the_one_sided():
    assert discrimination(table([0.9, 0.8, 0.1], [True, True, False])) == 1
    assert discrimination(table([0.5] * 4, [True, False] * 2)) == 0.5
    assert np.isnan(discrimination(table([0.5, 0.6], [True, True])))
    assert np.isnan(discrimination(table([], [])))

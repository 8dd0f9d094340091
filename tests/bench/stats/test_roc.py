"""What qualities are worth: the share of pairs in the right order, and their calibration."""

import numpy as np
import pandas as pd
import pytest

from egad.bench.stats import Rate, area, discrimination, gain, reliability
from egad.bench.stats.roc import MIN_OBJECTS, roc_area


def made(objects: int = 12, grasps: int = 20, seed: int = 0) -> tuple[np.ndarray, ...]:
    rng = np.random.default_rng(seed)
    names = np.repeat([f"o{n}" for n in range(objects)], grasps)
    rating = rng.integers(0, 9, len(names)) / 8
    return rating, rng.random(len(names)) < 0.2 + 0.6 * rating, names


def table(quality, success):
    return pd.DataFrame({"quality": quality, "success": success})


def test_it_is_the_share_of_pairs_in_the_right_order():
    rating, success, names = made()
    found = area(rating, success, names)
    apart = rating[success][:, None] - rating[~success]
    assert found.value == pytest.approx(((apart > 0) + 0.5 * (apart == 0)).mean())
    assert discrimination(table(rating, success)) == found.value
    low, high = found.interval
    assert low < found.value < high


def test_pairs_of_one_object_are_told_apart_from_others():
    names, success = np.array(["a", "a", "b", "b"]), np.array([True, False, True, False])
    found = area(np.array([0.4, 0.3, 0.9, 0.8]), success, names)
    assert (found.value, found.within) == (0.75, 1.0)
    rating, success, names = made()
    apart = [
        rating[success & (names == n)][:, None] - rating[~success & (names == n)] for n in names
    ]
    signs = np.sign(np.concatenate([each.ravel() for each in apart]))
    assert area(rating, success, names).within == pytest.approx((signs + 1).mean() / 2)


def test_an_object_drawn_twice_counts_twice(monkeypatch):
    rating, success, names = made(MIN_OBJECTS)
    drawn = np.array([[0, 0, 2, 3, 3], [1, 1, 1, 1, 1]])
    seen = []

    def bootstrap(statistic, count):
        assert count == MIN_OBJECTS
        seen.extend(statistic(drawn))
        return 0.0, 1.0

    monkeypatch.setattr("egad.bench.stats.roc.bootstrap", bootstrap)
    area(rating, success, names)
    for draw, value in zip(drawn, seen, strict=True):
        rows = np.concatenate([np.flatnonzero(names == f"o{n}") for n in draw])
        assert value == pytest.approx(roc_area(rating[rows], success[rows]))


def test_the_perfect_the_blind_and_the_one_sided():
    names = np.array(["a", "a", "b", "b"])
    success = np.array([True, False, True, False])
    assert area(np.array([0.9, 0.1, 0.8, 0.2]), success, names).value == 1
    assert area(np.full(4, 0.3), success, names).value == 0.5
    assert np.isnan(area(np.arange(4.0), np.full(4, True), names).value)
    nothing = area(np.empty(0), np.empty(0, bool), np.empty(0, "<U2"))
    assert np.isnan([nothing.value, *nothing.interval, nothing.within]).all()
    assert np.isnan(discrimination(table([], [])))


def test_failures_of_few_objects_give_no_interval():
    """All the failures of one object: drawn again and again, they would look certain."""
    rating, success, names = made()
    low, high = area(rating, success, names).interval
    assert high - low > 0.05
    for failing in (1, MIN_OBJECTS - 1):
        held = success | ~np.isin(names, [f"o{n}" for n in range(failing)])
        found = area(rating, held, names)
        assert np.isfinite(found.value)
        assert np.isnan(found.interval).all()


def test_what_one_rating_tells_more_than_another():
    rating, success, names = made(40)
    blind = np.random.default_rng(1).random(len(rating))
    found = gain(rating, blind, success, names)
    first, second = (area(each, success, names) for each in (rating, blind))
    assert found.value == pytest.approx(first.value - second.value)
    assert found.within == pytest.approx(first.within - second.within)
    assert 0 < found.interval[0] < found.value < found.interval[1]
    same = gain(rating, rating, success, names)
    assert (same.value, *same.interval) == (0, 0, 0)
    # Two ratings that are right and wrong together differ less than their intervals suggest.
    near = gain(rating, rating + 0.01 * blind, success, names)
    assert np.ptp(near.interval) < np.ptp(first.interval) / 2


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

"""The area under the ROC curve is the share of pairs in the right order, over drawn objects too."""

import numpy as np
import pandas as pd
import pytest

from egad.stats.roc import FEWEST, area, discrimination, gain


def made(objects: int = 12, grasps: int = 20, seed: int = 0) -> tuple[np.ndarray, ...]:
    rng = np.random.default_rng(seed)
    names = np.repeat([f"o{n}" for n in range(objects)], grasps)
    rating = rng.integers(0, 9, len(names)) / 8
    return rating, rng.random(len(names)) < 0.2 + 0.6 * rating, names


def test_it_is_the_share_of_pairs_in_the_right_order():
    rating, success, names = made()
    found = area(rating, success, names)
    expected = discrimination(pd.DataFrame({"quality": rating, "success": success}))
    assert found.value == pytest.approx(expected)
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
    rating, success, names = made(FEWEST)
    drawn = np.array([[0, 0, 2, 3, 3], [1, 1, 1, 1, 1]])
    seen = []

    def bootstrap(statistic, count):
        assert count == FEWEST
        seen.extend(statistic(drawn))
        return 0.0, 1.0

    monkeypatch.setattr("egad.stats.roc.bootstrap", bootstrap)
    area(rating, success, names)
    for draw, value in zip(drawn, seen, strict=True):
        rows = np.concatenate([np.flatnonzero(names == f"o{n}") for n in draw])
        table = pd.DataFrame({"quality": rating[rows], "success": success[rows]})
        assert value == pytest.approx(discrimination(table))


def test_the_perfect_the_blind_and_the_one_sided():
    names = np.array(["a", "a", "b", "b"])
    success = np.array([True, False, True, False])
    assert area(np.array([0.9, 0.1, 0.8, 0.2]), success, names).value == 1
    assert area(np.full(4, 0.3), success, names).value == 0.5
    assert np.isnan(area(np.arange(4.0), np.full(4, True), names).value)
    nothing = area(np.empty(0), np.empty(0, bool), np.empty(0, "<U2"))
    assert np.isnan([nothing.value, *nothing.interval, nothing.within]).all()


def test_failures_of_few_objects_give_no_interval():
    """All the failures of one object: drawn again and again, they would look certain."""
    rating, success, names = made()
    low, high = area(rating, success, names).interval
    assert high - low > 0.05
    for failing in (1, FEWEST - 1):
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

"""Ranks of detectors: ties where they cannot be told apart."""

import numpy as np
import pytest
from scipy.stats import studentized_range

from egad.bench.stats import Lead, Ranks, leads, ranks

SIZES = np.full(12, 20)
EVEN = np.array([15, 9] * 6)


def by_pair(found):
    return {frozenset((each.first, each.second)): each for each in found}


def test_mirrored_detectors_tie_and_a_worse_one_does_not():
    """What one gains at six objects it loses at the other six; the third has 6 to 8 fewer."""
    tables = {"one": EVEN, "mirrored": EVEN[::-1].copy(), "worse": EVEN - 7 + np.arange(12) % 3 - 1}
    pairs = leads(tables, SIZES)
    assert by_pair(pairs)[frozenset(("one", "mirrored"))].difference == 0
    assert ranks(list(tables), pairs) == {
        "one": Ranks(1, 2),
        "mirrored": Ranks(1, 2),
        "worse": Ranks(3, 3),
    }


def test_the_difference_is_that_of_the_sums_and_the_better_one_comes_first():
    (found,) = leads({"a": np.array([1, 2, 3, 4, 5, 6]), "b": np.arange(2, 8)}, np.arange(6) + 10)
    assert found[:2] == ("b", "a")
    assert found.difference == pytest.approx(6 / 75)


def test_intervals_of_three_detectors_are_as_wide_as_tukeys():
    """Of three exchangeable ones, the largest of the three differences has a studentized range."""
    count = 1000
    drawn = np.random.default_rng(0).integers(0, 21, (3, count))
    pairs = leads(dict(zip("abc", drawn, strict=True)), np.full(count, 20))
    expected = studentized_range.ppf(0.95, 3, np.inf) / np.sqrt(2)
    for each in pairs:
        one, other = (drawn["abc".index(name)] for name in each[:2])
        error = np.std((one - other) / 20, ddof=1) / np.sqrt(count)
        half = (each.interval[1] - each.interval[0]) / 2
        assert half / error == pytest.approx(expected, rel=0.04)
        assert np.mean(each.interval) == pytest.approx(each.difference)


def test_a_few_objects_cannot_tell_detectors_apart():
    good, bad = np.full(5, 20), np.zeros(5, dtype=int)
    (found,) = leads({"good": good, "bad": bad}, np.full(5, 20))
    assert not found.is_certain
    assert leads({"alone": good}, np.full(5, 20)) == []
    assert ranks(["alone"], []) == {"alone": Ranks(1, 1)}


@pytest.mark.parametrize("objects", [1, 2, 3])
def test_a_copy_that_differs_at_few_objects_leaves_the_others_their_ranks(objects):
    good = np.array([17, 18, 16, 20, 15, 19, 17] * 7)
    copy = good.copy()
    copy[:objects] -= 1
    tables = {"good": good, "copy": copy, "bad": good // 4}
    pairs = leads(tables, np.full(49, 20))
    assert np.isfinite([each.interval for each in pairs]).all()
    assert ranks(list(tables), pairs) == {
        "good": Ranks(1, 2),
        "copy": Ranks(1, 2),
        "bad": Ranks(3, 3),
    }


def test_a_chain_of_ties_whose_ends_differ():
    pairs = [
        Lead("a", "b", 0.1, (-0.1, 0.3)),
        Lead("b", "c", 0.1, (-0.1, 0.3)),
        Lead("a", "c", 0.2, (0.01, 0.4)),
    ]
    found = ranks(["a", "b", "c"], pairs)
    assert found == {"a": Ranks(1, 2), "b": Ranks(1, 3), "c": Ranks(2, 3)}
    assert [str(each).split("\N{EN DASH}") for each in found.values()] == [
        ["1", "2"],
        ["1", "3"],
        ["2", "3"],
    ]
    assert str(Ranks(4, 4)) == "4"

"""Cohen's kappa against hand calculation, and a slow count over the same draws."""

import numpy as np
import pytest

from egad.bench.stats import Rate, cohen_kappa, kappa


def labels(both, only_first, only_second, neither):
    first = np.repeat([True, True, False, False], [both, only_first, only_second, neither])
    second = np.repeat([True, False, True, False], [both, only_first, only_second, neither])
    return first, second, np.arange(len(first)).astype(str)


def test_kappa_of_a_table_that_is_calculated_by_hand():
    """They agree in 35 of 50; by chance in 0.5 * 0.6 + 0.5 * 0.4 of the cases."""
    found = cohen_kappa(*labels(20, 5, 10, 15))
    assert found.agreement == Rate(35, 50)
    assert found.value == pytest.approx((0.7 - 0.5) / (1 - 0.5))
    assert (found.both, found.only_first, found.only_second, found.neither) == (20, 5, 10, 15)
    low, high = found.interval
    assert 0.05 < low < 0.2 < 0.6 < high < 0.75


def test_equal_labels_have_kappa_1_opposite_ones_below_0_and_constants_none():
    assert cohen_kappa(*labels(6, 0, 0, 4)).value == 1
    assert cohen_kappa(*labels(0, 5, 5, 0)).value == -1
    assert cohen_kappa(*labels(9, 3, 3, 1)).value == pytest.approx(0)
    assert np.isnan(cohen_kappa(*labels(7, 0, 0, 0)).value)
    nothing = cohen_kappa(*labels(0, 0, 0, 0))
    assert np.isnan([nothing.value, *nothing.interval]).all()


def test_an_object_drawn_twice_counts_twice(monkeypatch):
    rng = np.random.default_rng(0)
    first, second = rng.random((2, 60)) < 0.5
    groups = rng.choice(["a", "b", "c"], 60)
    drawn = np.array([[0, 0, 2], [1, 2, 1]])
    monkeypatch.setattr(kappa, "bootstrap", lambda statistic, _: tuple(statistic(drawn)))
    found = cohen_kappa(first, second, groups).interval
    for value, draw in zip(found, drawn, strict=True):
        rows = np.concatenate([np.flatnonzero(groups == "abc"[each]) for each in draw])
        single = np.arange(len(rows)).astype(str)
        monkeypatch.setattr(kappa, "bootstrap", lambda *_: (0, 0))
        assert value == pytest.approx(cohen_kappa(first[rows], second[rows], single).value)

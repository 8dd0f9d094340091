"""Means of independent runs compared: against slow and obvious twins."""

import numpy as np
import pytest
from scipy import stats

from egad.stats import difference_of_means, holm

ONE, OTHER = [0.61, 0.66, 0.58, 0.63, 0.6], [0.52, 0.57, 0.5, 0.56]


def test_welch_by_hand():
    """Welch (1947) and Satterthwaite's degrees of freedom, written out."""
    found = difference_of_means(ONE, OTHER)
    parts = [np.var(each, ddof=1) / len(each) for each in (ONE, OTHER)]
    error = np.sqrt(sum(parts))
    freedom = sum(parts) ** 2 / sum(
        part**2 / (len(each) - 1) for part, each in zip(parts, (ONE, OTHER), strict=True)
    )
    gain = np.mean(ONE) - np.mean(OTHER)
    reach = stats.t.ppf(0.975, freedom) * error
    assert found.gain == pytest.approx(gain)
    assert found.interval == pytest.approx((gain - reach, gain + reach))
    assert found.p == pytest.approx(2 * stats.t.sf(gain / error, freedom))
    turned = difference_of_means(OTHER, ONE)
    assert (turned.gain, turned.p) == pytest.approx((-found.gain, found.p))
    assert turned.interval == pytest.approx((-found.interval[1], -found.interval[0]))


def test_p_of_networks_is_about_that_of_all_ways_to_deal_them_out():
    """The slow twin: a permutation test of the t statistic."""
    rng = np.random.default_rng(3)
    values = rng.normal(0.6, 0.03, 16)
    values[:8] += 0.03

    def statistic(each):
        return abs(stats.ttest_ind(each[:8], each[8:], equal_var=False).statistic)

    least = statistic(values)
    dealt = [statistic(rng.permutation(values)) >= least for _ in range(2000)]
    assert difference_of_means(values[:8], values[8:]).p == pytest.approx(np.mean(dealt), abs=0.03)


def test_a_difference_of_equal_sets_is_found_in_a_twentieth_of_the_cases():
    rng = np.random.default_rng(4)
    draws = rng.normal(0.6, 0.03, (600, 10))
    found = [difference_of_means(values[:5], values[5:]) for values in draws]
    assert np.mean([each.p < 0.05 for each in found]) == pytest.approx(0.05, abs=0.03)
    covered = [each.interval[0] < 0 < each.interval[1] for each in found]
    assert [each.p > 0.05 for each in found] == covered


def test_a_single_network_is_a_fixed_number_for_the_others():
    found, turned = difference_of_means(ONE, [0.5]), difference_of_means([0.5], ONE)
    error = np.std(ONE, ddof=1) / np.sqrt(5)
    gain = np.mean(ONE) - 0.5
    assert found.p == pytest.approx(2 * stats.t.sf(gain / error, 4))
    reach = stats.t.ppf(0.975, 4) * error
    assert found.interval == pytest.approx((gain - reach, gain + reach))
    assert (turned.gain, turned.p) == pytest.approx((-found.gain, found.p))
    assert turned.interval == pytest.approx((-gain - reach, -gain + reach))
    alone = difference_of_means([0.7], [0.5])
    assert alone.gain == pytest.approx(0.2)
    assert np.isnan([alone.p, *alone.interval]).all()


def rejected_by_holm(p_values, level):
    """The definition: in ascending order, reject until the first that is above level / left."""
    order = np.argsort(p_values)
    rejected = np.zeros(len(p_values), dtype=bool)
    for step, place in enumerate(order):
        if p_values[place] > level / (len(p_values) - step):
            break
        rejected[place] = True
    return rejected


@pytest.mark.parametrize("seed", range(5))
def test_holm_rejects_what_its_steps_reject(seed):
    p_values = np.random.default_rng(seed).beta(0.3, 2, size=15)
    corrected = holm(p_values)
    for level in np.random.default_rng(seed).uniform(0, 1, 50):
        assert ((corrected <= level) == rejected_by_holm(p_values, level)).all()


def test_holm_of_few():
    assert holm(np.array([0.03])).tolist() == [0.03]
    assert holm(np.array([])).tolist() == []
    assert holm(np.array([0.04, 0.01, 0.03])) == pytest.approx([0.06, 0.03, 0.06])
    assert holm(np.array([0.9, 0.8])).tolist() == [1.0, 1.0]
    assert holm(np.array([np.nan, 0.01])) == pytest.approx([np.nan, 0.02], nan_ok=True)

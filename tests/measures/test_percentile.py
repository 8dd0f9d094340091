import itertools

import numpy as np
import pytest
from scipy import stats

from egad.measures.percentile import (
    BoundedSample,
    confidence_between,
    percentile,
    percentile_rank,
    percentile_std,
)


def sample(values, slack=0.0, seed=0):
    """Values behind bounds that exceed them by some random part; and what was computed."""
    values = np.asarray(values, dtype=float)
    asked = []

    def compute(indices, limit):
        """The values; halfway to the limit instead of those that are below."""
        asked.extend(indices)
        return np.where(values[indices] < limit, (values[indices] + limit) / 2, values[indices])

    found = BoundedSample(compute)
    rng = np.random.default_rng(seed)
    for part in np.array_split(values, 3):
        found.extend(part * (1 + slack * rng.random(len(part))))
    return found, asked


@pytest.mark.parametrize(
    ("values", "percent", "expected"),
    [
        (range(100), 75, 75),  # the 76th smallest
        ([3, 1, 2], 75, 3),
        ([5, 0, 0, 0], 75, 5),
        ([5, 0, 0, 0], 74, 0),
        ([7], 0, 7),
        ([7, 8], 100, 8),
    ],
)
def test_percentile_is_a_plain_index(values, percent, expected):
    assert percentile(np.array(values, dtype=float), percent) == expected


@pytest.mark.parametrize("slack", [0.0, 0.2, 5.0])
@pytest.mark.parametrize("ties", [False, True])
def test_bounded_values_give_what_all_values_give(slack, ties):
    rng = np.random.default_rng(1)
    values = rng.gamma(2, size=500) * (rng.random(500) < 0.8)
    values = np.round(values, 1) if ties else values
    for rank in (0, 1, 100, 375, 498, 499):
        assert sample(values, slack)[0].smallest(rank) == np.sort(values)[rank]
    for limit in (0.0, 1.0, 2.5, values.max(), 100.0):
        assert sample(values, slack)[0].below(limit) == np.sum(values < limit)


def test_only_values_that_matter_are_computed_and_hardly_any_twice():
    values = np.random.default_rng(2).gamma(2, size=1000)
    found, asked = sample(values, 0.1)
    found.smallest(percentile_rank(1000, 75))
    assert 250 <= len(asked) < 400
    found.smallest(percentile_rank(1000, 75))
    found.below(np.sort(values)[700])
    assert len(set(asked)) < 500
    assert len(asked) < 1.2 * len(set(asked))


def test_exact_values_are_not_computed():
    found = BoundedSample(lambda *_: pytest.fail("computed"))
    found.extend(np.array([1.0, 0.0, 3.0]), exact=True)
    assert found.smallest(1) == 1
    assert found.below(2) == 2


def test_the_standard_error_is_the_spread_of_repeated_samples():
    rng = np.random.default_rng(0)
    samples = np.sort(rng.gamma(2, size=(4000, 400)), axis=1)
    spread = samples[:, 300].std()
    told = np.mean([percentile_std(sample(each)[0], 75) for each in samples[:400]])
    assert told == pytest.approx(spread, rel=0.1)


def test_confidence_is_how_often_it_holds():
    """On grids that lie anywhere, the percentile is in the cell as often as is said."""
    rng = np.random.default_rng(0)
    truth, width = stats.gamma(2).ppf(0.75), 0.5
    told, held = np.empty(4000), np.empty(4000, dtype=bool)
    for i in range(4000):
        found, _ = sample(rng.gamma(2, size=300))
        offset = rng.uniform(0, width)
        cell = np.floor((found.smallest(225) - offset) / width)
        limits = offset + cell * width, offset + (cell + 1) * width
        told[i] = confidence_between(found, 75, limits)
        held[i] = limits[0] <= truth < limits[1]
    for low, high in ((0.0, 0.6), (0.6, 0.8), (0.8, 1.0)):
        some = (told >= low) & (told <= high)
        assert some.sum() > 500
        assert held[some].mean() == pytest.approx(told[some].mean(), abs=0.07)


def test_confidence_adds_up_over_all_intervals():
    found, _ = sample(np.random.default_rng(3).gamma(2, size=300))
    edges = [-np.inf, 1.0, 2.0, 2.5, 3.0, np.inf]
    pairs = list(itertools.pairwise(edges))
    parts = [confidence_between(found, 75, pair) for pair in pairs]
    assert sum(parts) == pytest.approx(1)
    assert max(parts) == confidence_between(found, 75, (2.5, 3.0)) > 0.7


@pytest.mark.parametrize("value", [0.5, 1.0])
def test_a_percentile_of_equal_values_is_certain(value):
    found, _ = sample(np.full(400, value))
    assert confidence_between(found, 75, (0.5, 1.5)) == pytest.approx(1, abs=1e-6)
    assert percentile_std(found, 75) == 0

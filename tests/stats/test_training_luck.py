import numpy as np
import pytest

from egad.stats.rates import Mean, Rate
from egad.stats.training_study import SetRate, luck

ATTEMPTS = 1000


def tried(**successes):
    return {
        name: SetRate(Mean(0, 0, 0, 0), {seed: Rate(n, ATTEMPTS) for seed, n in enumerate(counts)})
        for name, counts in successes.items()
    }


def test_the_spread_is_that_within_sets_and_f_its_share_by_the_definition():
    found = luck(tried(few=[500, 560], many=[600, 640], given=[900]))
    means, squares = [0.53, 0.62], 2 * 0.03**2 + 2 * 0.02**2
    assert found.spread == pytest.approx(np.sqrt(squares / 2))
    assert (found.sets, found.networks) == (2, 4)
    between = 2 * sum((mean - np.mean(means)) ** 2 for mean in means)
    assert found.f == pytest.approx(between / (squares / 2))


def test_p_is_that_of_shuffled_networks():
    """The twin: networks dealt to the sets at random, and how often they differ as much."""
    rng = np.random.default_rng(1)
    counts = np.sort(rng.integers(400, 700, 12))[[0, 3, 1, 2, 5, 8, 4, 6, 7, 9, 10, 11]]

    def of(values):
        return luck(tried(**{str(k): row for k, row in enumerate(values.reshape(3, 4))}))

    first = of(counts)
    dealt = [of(rng.permutation(counts)).f >= first.f for _ in range(4000)]
    assert first.p == pytest.approx(np.mean(dealt), abs=0.02)


@pytest.mark.parametrize(
    "rates", [tried(a=[1], b=[2]), tried(a=[1, 2], b=[3]), tried(a=[5, 5], b=[7, 7]), {}]
)
def test_nothing_is_said_where_no_luck_was_seen(rates):
    assert luck(rates) is None

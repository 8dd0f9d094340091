"""Training sets compared: against slow and obvious twins, and against what must come out."""

from itertools import combinations

import numpy as np
import pandas as pd
import pytest

from egad.errors import UserError
from egad.stats.paired import sign_flip
from egad.stats.rates import Mean, Rate, mean_rate
from egad.stats.training_study import (
    SetRate,
    by_set,
    by_test,
    check_starts,
    holm,
    references,
    seed_variance,
    set_pairs,
    set_rate,
)

OBJECTS = [f"{letter}{digit}" for letter in "ABC" for digit in range(3)]
SETS = {"poor": (0.2, 2), "good": (0.8, 2), "given": (0.5, 1)}


def tried(name, seed, rate, rng, attempts=6):
    rows = [
        (name, seed, label, label, n, bool(rng.random() < rate), f"drop-{label}-{n}")
        for label in OBJECTS
        for n in range(attempts)
    ]
    columns = ["training_set", "seed", "label", "id", "attempt", "success", "initial_pose"]
    detector = f"{name}-{seed}" if name else "random"
    return pd.DataFrame(rows, columns=columns).assign(detector=detector)


@pytest.fixture(scope="module")
def table():
    rng = np.random.default_rng(1)
    networks = [
        tried(name, seed, rate, rng)
        for name, (rate, seeds) in SETS.items()
        for seed in range(seeds)
    ]
    return pd.concat([*networks, tried("", 0, 0.1, rng)], ignore_index=True)


def test_the_table_is_taken_apart_in_its_order(table):
    assert list(by_set(table)) == list(SETS)
    assert list(references(table)) == ["random"]
    parts = [*by_set(table).values(), *references(table).values()]
    assert sum(map(len, parts)) == len(table)


def test_each_test_has_its_own_rates(table):
    found = by_test(pd.concat([table.assign(test="one"), table[::2].assign(test="two")]))
    assert list(found) == ["one", "two"]
    for tried, rows in ((found["one"], table), (found["two"], table[::2])):
        assert len(tried.rows) == len(rows)
        assert tried.sets == {name: set_rate(own) for name, own in by_set(rows).items()}
        assert tried.references == {"random": mean_rate(references(rows)["random"])}


def test_a_rate_is_that_of_all_networks_and_each_is_there(table):
    rows = by_set(table)["good"]
    found = set_rate(rows)
    assert found.pooled == mean_rate(rows)
    assert (found.pooled.attempts, list(found.each)) == (2 * 6 * len(OBJECTS), [0, 1])
    assert np.mean([each.value for each in found.each.values()]) == found.pooled.value


def test_a_second_network_that_answers_the_same_adds_no_certainty(table):
    """Attempts on an object are no new objects: the interval by the objects stays as it is."""
    alone = by_set(table)["good"].query("seed == 0")
    alone = alone.assign(success=alone["label"].isin(["A0", "B1", "C2"]))
    twice = pd.concat([alone, alone.assign(seed=1)])
    assert set_rate(twice).pooled.interval == pytest.approx(set_rate(alone).pooled.interval)


def gains(table, first, second):
    """By object, network by network: the sum of successes of one set less that of the other."""
    sets = by_set(table)
    counts = {name: sets[name]["seed"].nunique() for name in (first, second)}
    found = []
    for label in OBJECTS:
        gain = 0
        for network in range(2):
            for name, sign in ((first, 1), (second, -1)):
                rows = sets[name]
                own = rows[(rows["label"] == label) & (rows["seed"] == network % counts[name])]
                gain += sign * int(own["success"].sum())
        found.append(gain)
    return np.array(found)


def test_every_pair_is_compared_over_the_objects(table):
    pairs = set_pairs(by_set(table))
    assert {frozenset((pair.first, pair.second)) for pair in pairs} == {
        frozenset(names) for names in combinations(SETS, 2)
    }
    for pair in pairs:
        found = gains(table, pair.first, pair.second)
        assert pair.result.objects == len(OBJECTS)
        assert pair.result.difference == pytest.approx(found.sum() / (2 * 6 * len(OBJECTS)))
        assert pair.result.difference >= 0
        assert pair.result.p_objects == pytest.approx(sign_flip(found))
        assert pair.p_holm >= pair.result.p_objects


def test_the_difference_is_that_of_the_rates(table):
    """Also where one set has one network and the other two."""
    rates = {name: set_rate(rows).pooled.value for name, rows in by_set(table).items()}
    for pair in set_pairs(by_set(table)):
        assert pair.result.difference == pytest.approx(rates[pair.first] - rates[pair.second])


def test_each_pair_of_networks_is_compared_alone(table):
    rates = {name: set_rate(rows).each for name, rows in by_set(table).items()}
    for pair in set_pairs(by_set(table)):
        one, other = (
            [each.value for each in rates[name].values()] for name in (pair.first, pair.second)
        )
        expected = np.subtract(one, other)  # a single network is against each of the other set
        assert pair.each == pytest.approx(expected.tolist())
        assert pair.result.difference == pytest.approx(np.mean(pair.each))


def test_numbers_of_networks_that_make_no_pairs_are_refused(table):
    sets = by_set(table)
    third = sets["good"][sets["good"]["seed"] == 0].assign(seed=2)
    three = pd.concat([sets["good"], third])
    with pytest.raises(UserError, match="2 networks of poor and 3 of three cannot be paired"):
        set_pairs({"poor": sets["poor"], "three": three})
    (pair,) = set_pairs({"given": sets["given"], "three": three})
    assert len(pair.each) == 3


def test_two_single_networks_count_once_whatever_the_other_sets_have(table):
    sets = by_set(table)
    alone = {name: sets[name][sets[name]["seed"] == 0] for name in ("good", "given")}
    pairs = set_pairs({**alone, "poor": sets["poor"]})
    attempts = {(pair.first, pair.second): pair.result.attempts for pair in pairs}
    assert attempts["good", "given"] == 6 * len(OBJECTS)
    assert attempts["good", "poor"] == 2 * 6 * len(OBJECTS)


def test_what_began_alike_is_counted_and_what_should_have_is_refused(table):
    sets = by_set(table)
    moved = sets["poor"].copy()
    moved.iloc[:3, moved.columns.get_loc("initial_pose")] = "elsewhere"
    (pair,) = set_pairs({"good": sets["good"], "poor": moved})
    assert (pair.result.attempts, pair.result.alike) == (len(moved), len(moved) - 3)
    check_starts(table)
    with pytest.raises(UserError, match="poor-0 started attempt 0 at A0 with a different drop"):
        check_starts(pd.concat([sets["good"], moved]))


def test_an_attempt_that_never_began_is_no_other_drop(table):
    sets = by_set(table)
    check_starts(pd.concat([sets["poor"].assign(start=""), sets["good"]]))


def test_the_same_network_is_not_better_than_itself(table):
    sets = by_set(table)
    (pair,) = set_pairs({"good": sets["good"], "again": sets["good"]})
    assert (pair.result.difference, pair.result.p_objects, pair.p_holm) == (0.0, 1.0, 1.0)


def test_a_single_set_has_no_pairs(table):
    assert set_pairs({"good": by_set(table)["good"]}) == []


def test_other_objects_of_the_same_name_are_refused(table):
    sets = by_set(table)
    with pytest.raises(UserError, match="only trials of the same evaluation set can be compared"):
        set_pairs({"good": sets["good"], "poor": sets["poor"].assign(id="another")})


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


ATTEMPTS = 1000


def set_rates(**successes):
    return {
        name: SetRate(Mean(0, 0, 0, 0), {seed: Rate(n, ATTEMPTS) for seed, n in enumerate(counts)})
        for name, counts in successes.items()
    }


def test_the_spread_is_that_within_sets_and_f_its_share_by_the_definition():
    found = seed_variance(set_rates(few=[500, 560], many=[600, 640], given=[900]))
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
        return seed_variance(
            set_rates(**{str(k): row for k, row in enumerate(values.reshape(3, 4))})
        )

    first = of(counts)
    dealt = [of(rng.permutation(counts)).f >= first.f for _ in range(4000)]
    assert first.p == pytest.approx(np.mean(dealt), abs=0.02)


@pytest.mark.parametrize(
    "rates",
    [set_rates(a=[1], b=[2]), set_rates(a=[1, 2], b=[3]), set_rates(a=[5, 5], b=[7, 7]), {}],
)
def test_nothing_is_said_where_no_luck_was_seen(rates):
    assert seed_variance(rates) is None

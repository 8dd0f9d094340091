"""Paired tests against scipy's, and against what must come out."""

from itertools import product

import numpy as np
import pandas as pd
import pytest
from scipy.stats import binomtest

from egad.bench.stats import NothingInCommonError, Rate, boschloo, compare
from egad.bench.stats.paired import mcnemar, sign_flip
from egad.errors import UserError


def tried(rates, attempts=20, seed=0, drops="drop"):
    """Attempts at objects A0, A1, ... with the rates given."""
    rng = np.random.default_rng(seed)
    rows = [
        (f"{'ABCDEFG'[i // 7]}{i % 7}", f"id-{i}", n, bool(rng.random() < rate), f"{drops}-{i}-{n}")
        for i, rate in enumerate(rates)
        for n in range(attempts)
    ]
    return pd.DataFrame(rows, columns=["label", "id", "attempt", "success", "initial_pose"])


@pytest.mark.parametrize(
    "gains", [[5], [3, -3], [0, 0, 4], [6, -1, 2, 0, 9], [1, 1, 1, 1, 1, 1, -20], [2, 3, 5, 7, 11]]
)
def test_sign_flips_are_counted_over_all_signs(gains):
    """The definition: of all signs, the share whose sum is as far from nothing or further."""
    sums = [abs(np.dot(signs, gains)) for signs in product((-1, 1), repeat=len(gains))]
    assert sign_flip(np.array(gains)) == pytest.approx(np.mean(np.array(sums) >= abs(sum(gains))))


def test_the_p_values_are_those_of_the_tables():
    """A0: 3 of 4 against 1; A1: 2 of 4 against 1; A2: 1 of 4 against 3, all in other attempts."""
    held = {"A0": ("1110", "0001"), "A1": ("1100", "1000"), "A2": ("0001", "1110")}
    first, second = tried([0.0] * 3, 4), tried([0.0] * 3, 4)
    for table, each in ((first, 0), (second, 1)):
        table["success"] = [bit == "1" for pair in held.values() for bit in pair[each]]
    found = compare(first, second)
    assert found.difference == pytest.approx(1 / 12)
    assert (found.only_first, found.only_second) == (5, 4)
    assert found.p_attempts == pytest.approx(binomtest(5, 9).pvalue)
    assert found.p_objects == sign_flip(np.array([2, 1, -2])) == 1


def test_no_differences_are_no_evidence():
    assert sign_flip(np.zeros(49, dtype=np.int64)) == 1
    assert sign_flip(np.array([], dtype=np.int64)) == 1
    assert sign_flip(np.array([3])) == 1
    assert mcnemar(0, 0) == 1


def test_equals_are_told_apart_as_rarely_as_the_level_says():
    """Two detectors of the same true rates: p < 0.05 in no more than 5 % of the evaluations."""
    rates = np.random.default_rng(0).beta(1.2, 0.8, 14)
    values = [
        compare(tried(rates, 6, 2 * i), tried(rates, 6, 2 * i + 1)).p_objects for i in range(150)
    ]
    assert np.mean(np.array(values) < 0.05) <= 0.09


def test_the_other_way_round_everything_is_turned():
    a, b = tried([0.8] * 7), tried([0.4] * 7, seed=3)
    one, other = compare(a, b), compare(b, a)
    assert one.difference == -other.difference
    assert (one.only_first, one.only_second) == (other.only_second, other.only_first)
    assert (one.p_objects, one.p_attempts) == (other.p_objects, other.p_attempts)
    assert one.interval == pytest.approx([-end for end in reversed(other.interval)], abs=0.01)


def test_only_attempts_that_both_made_count():
    found = compare(tried([1.0] * 7, 20), tried([0.0] * 5, 10))
    assert (found.objects, found.attempts) == (5, 50)


@pytest.mark.parametrize("drops", ["other", ""])
def test_other_drops_are_no_pairs_of_attempts(drops):
    second = tried([0.5] * 7, drops=drops)
    second["initial_pose"] = drops and second["initial_pose"]
    found = compare(tried([0.5] * 7), second)
    assert np.isnan(found.p_attempts)
    assert 0 <= found.p_objects <= 1


@pytest.mark.parametrize("first_too", [True, False])
def test_objects_known_by_label_only_are_no_pairs_of_attempts(first_too):
    first, second = tried([0.5] * 7), tried([0.4] * 7).assign(id="")
    found = compare(first.assign(id="") if first_too else first, second)
    assert np.isnan(found.p_attempts)
    assert found.p_objects == compare(tried([0.5] * 7), tried([0.4] * 7)).p_objects


def test_attempts_that_began_differently_are_no_pairs():
    """One table goes on from its own successes: only the first attempts began alike."""
    first, second = tried([0.9] * 7), tried([0.2] * 7, seed=1)
    second.loc[second["attempt"] > 0, "initial_pose"] += "-elsewhere"
    found, alone = compare(first, second), [t[t["attempt"] == 0] for t in (first, second)]
    assert (found.attempts, found.alike) == (140, 7)
    assert found.p_attempts == compare(*alone).p_attempts
    assert found.difference == compare(first, tried([0.2] * 7, seed=1)).difference


def test_tables_with_nothing_in_common_cannot_be_compared():
    with pytest.raises(NothingInCommonError, match="no attempt in common"):
        compare(tried([1.0]), tried([1.0]).assign(label="G6"))


def test_a_label_of_another_object_is_the_users_mistake():
    """Another evaluation set has a B2 too."""
    other = tried([1.0] * 10)
    other.loc[other["label"] == "B2", "id"] = "id-99"
    with pytest.raises(UserError, match="B2 is the object id-9 in one table and id-99") as raised:
        compare(tried([1.0] * 10), other)
    assert not isinstance(raised.value, NothingInCommonError)


@pytest.mark.parametrize(
    ("one", "other", "attempts", "p"), [(10, 6, 10, 0.042), (18, 12, 20, 0.039)]
)
def test_boschloo_finds_what_fisher_does_not(one, other, attempts, p):
    """Fisher's p-values are 0.087 and 0.065."""
    pair = Rate(one, attempts), Rate(other, attempts)
    assert boschloo(*pair) == pytest.approx(p, abs=0.0006)
    assert boschloo(*reversed(pair)) == pytest.approx(boschloo(*pair))


@pytest.mark.parametrize(("fewer", "more", "p"), [(0, 6, 2 * 0.5**6), (5, 15, 0.041)])
def test_mcnemar_is_exact_and_no_mid_p(fewer, more, p):
    assert mcnemar(more, fewer) == mcnemar(fewer, more) == pytest.approx(p, abs=0.0006)


def test_few_objects_on_a_robot_are_compared_by_their_successes():
    first, second = (table.assign(id="", initial_pose="") for table in (tried([1.0]), tried([0.6])))
    found = compare(first, second)
    won = int(second["success"].sum())
    assert found.p_objects == 1  # a single object has no preferred sign
    assert found.p_rates == boschloo(Rate(20, 20), Rate(won, 20)) < 0.05
    assert "test over the attempts at these objects: p = " in repr(found)


@pytest.mark.parametrize(
    ("objects", "attempts", "changes"),
    [(6, 5, {"initial_pose": ""}), (5, 5, {}), (1, 401, {"initial_pose": ""})],
)
def test_successes_are_not_compared_where_another_test_can_or_it_takes_long(
    objects, attempts, changes
):
    pair = (tried([0.5] * objects, attempts, seed).assign(**changes) for seed in (0, 1))
    assert np.isnan(compare(*pair).p_rates)

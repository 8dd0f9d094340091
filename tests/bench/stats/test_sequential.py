"""The test that allows looking: against a slow twin, and what it promises."""

from itertools import product

import numpy as np
import pandas as pd
import pytest

from egad.bench.stats import NothingInCommonError, attempts_in_a_row, in_rounds, sequential_test
from egad.bench.stats.sequential import log_e_values, two_sided
from egad.errors import UserError


def streams(one, other, pairs, runs, seed=0):
    rng = np.random.default_rng(seed)
    return rng.random((runs, pairs)) < one, rng.random((runs, pairs)) < other


def decided(values, level=0.05):
    """Whether each run had decided after each pair."""
    return np.maximum.accumulate(values >= np.log(1 / level), axis=1)


def table(successes, labels=None, attempts=None):
    count = len(successes)
    return pd.DataFrame(
        {
            "label": ["A0"] * count if labels is None else labels,
            "id": "",
            "attempt": range(count) if attempts is None else attempts,
            "success": successes,
            "initial_pose": "",
        }
    )


def slow_e_value(first, second):
    """One pair after the other, as the method is written down."""
    e = 1.0
    one, other = [2, 1], [1, 2]  # successes and failures so far, with those of the priors
    for a, b in zip(first, second, strict=True):
        p, q = one[0] / sum(one), other[0] / sum(other)
        if p > q:
            m = (p + q) / 2
            e *= (p if a else 1 - p) * (q if b else 1 - q)
            e /= (m if a else 1 - m) * (m if b else 1 - m)
        one[0 if a else 1] += 1
        other[0 if b else 1] += 1
    return e


def test_e_values_are_those_of_a_slow_twin():
    first, second = streams(0.7, 0.5, 40, 30)
    values = np.exp(log_e_values(first, second))
    for run in range(30):
        for count in (1, 2, 17, 40):
            slow = slow_e_value(first[run, :count], second[run, :count])
            assert values[run, count - 1] == pytest.approx(slow, rel=1e-10)


@pytest.mark.parametrize(
    ("one", "other", "power", "median"),
    [
        (0.9, 0.5, (0.61, 0.97, 1.00, 1.00), 17),
        (0.8, 0.5, (0.30, 0.68, 0.96, 1.00), 34),
        (0.7, 0.5, (0.13, 0.32, 0.57, 0.88), 85),
        (0.5, 0.5, (0.018, 0.022, 0.023, 0.025), np.inf),
    ],
)
def test_the_power_is_that_of_another_implementation(one, other, power, median):
    """Computed elsewhere with 2000 runs, one-sided at 0.05."""
    done = decided(log_e_values(*streams(one, other, 200, 4000)))
    found = done[:, [19, 49, 99, 199]].mean(axis=0)
    error = np.sqrt(np.array(power) * (1 - np.array(power)) * (1 / 2000 + 1 / 4000))
    assert found == pytest.approx(power, abs=0.006 + 3 * error.max())
    stops = np.where(done[:, -1], done.argmax(axis=1) + 1, np.inf)
    assert np.median(stops) == pytest.approx(median, abs=0.05 * min(median, 100))


@pytest.mark.parametrize("rate", [0.02, 0.5, 0.9])
@pytest.mark.parametrize("level", [0.05, 0.2])
def test_whoever_looks_after_every_pair_is_wrong_as_rarely_as_the_level_says(rate, level):
    first, second = streams(rate, rate, 1000, 2000)
    forwards, backwards = log_e_values(first, second), log_e_values(second, first)
    for values in (forwards, two_sided(forwards, backwards)):
        assert decided(values, level)[:, -1].mean() <= level


@pytest.mark.parametrize("rates", [(0.5, 0.5), (0.9, 0.9), (0.3, 0.6)])
@pytest.mark.parametrize("together", [0.0, 0.7])
def test_no_pair_is_expected_to_add_evidence_without_a_difference(rates, together):
    """The mean factor of the next pair is at most 1, by enumeration, whatever came before.

    Pairs may depend on each other as attempts at one object do: `together` of the way to the
    closest that these two rates can come.
    """
    p, q = rates
    both = p * q + together * (min(p, q) - p * q)
    chances = {(1, 1): both, (1, 0): p - both, (0, 1): q - both, (0, 0): 1 - p - q + both}
    for history in product(*[[(1, 1), (1, 0), (0, 1), (0, 0)]] * 3):
        means = 0.0
        for last, chance in chances.items():
            first, second = np.array([*history, last], dtype=bool).T
            values = log_e_values(first, second)
            means += chance * np.exp(values[-1] - values[-2])
        assert means <= 1 + 1e-12


def test_two_sided_evidence_is_the_mean_of_both_directions():
    first, second = streams(0.9, 0.4, 60, 1)
    found = sequential_test(table(first[0]), table(second[0]))
    twins = [
        [slow_e_value(a[: n + 1], b[: n + 1]) for n in range(60)]
        for a, b in ((first[0], second[0]), (second[0], first[0]))
    ]
    mean = np.mean(twins, axis=0)
    assert found.e_values == pytest.approx(mean)
    assert found.better == "first"
    assert found.decided_after == np.flatnonzero(mean >= 20)[0] + 1
    assert found.p_value == pytest.approx(1 / mean.max())
    assert found.e_value == pytest.approx(mean[-1])
    assert f"the first is better, after {found.decided_after} pairs" in repr(found)


def test_evidence_beyond_all_numbers_is_infinite():
    found = sequential_test(table([True] * 3000), table([False] * 3000))
    assert found.e_value == np.inf
    assert (found.p_value, found.better) == (0, "first")


def test_a_pair_counts_when_both_attempts_have_been_made():
    """The second tried the objects in another order; rows are in the order of the attempts."""
    one = table([True, False, True, True], ["A0", "A1", "A2", "A3"], [0] * 4)
    other = table([False, True, False, True], ["A3", "A0", "A1", "A2"], [0] * 4)
    complete = ["A0", "A1", "A2", "A3"]  # A0 and A3 wait for the other table
    lists = [
        [bool(each.set_index("label").loc[label, "success"]) for label in complete]
        for each in (one, other)
    ]
    found = sequential_test(one, other, one_sided=True)
    assert found.e_values == pytest.approx(
        [slow_e_value(lists[0][: n + 1], lists[1][: n + 1]) for n in range(4)]
    )


def test_what_only_one_of_them_tried_does_not_count():
    found = sequential_test(table([True] * 5), table([False] * 3))
    assert len(found.e_values) == 3


def test_what_cannot_be_tested_is_told():
    with pytest.raises(NothingInCommonError):
        sequential_test(table([True]), table([True], ["B1"]))
    for level in (0, 1, -0.1, 2, float("nan")):
        with pytest.raises(UserError, match=r"level is .*; allowed: a number above 0 and below 1"):
            sequential_test(table([True]), table([True]), level)


def test_rounds_have_every_object_once_in_random_order():
    labels, numbers = np.repeat(["A0", "A1", "B0", "B1", "C0"], 6), np.tile(np.arange(6), 5)
    frame = table([True] * 30, labels, numbers)
    rounds = in_rounds(frame)
    assert rounds["attempt"].tolist() == sorted(numbers)
    orders = rounds["label"].to_numpy().reshape(6, 5)
    assert {tuple(sorted(each)) for each in orders} == {("A0", "A1", "B0", "B1", "C0")}
    assert len({tuple(each) for each in orders}) > 3
    pd.testing.assert_frame_equal(in_rounds(frame.iloc[::-1]), rounds)
    assert attempts_in_a_row(frame) == 6
    assert attempts_in_a_row(rounds) <= 2

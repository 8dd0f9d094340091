"""What a comparison shows, in a sentence."""

import re

import numpy as np
import pandas as pd
import pytest

from egad.stats import (
    ObjectRates,
    clearing_conclusion,
    compare,
    conclusion,
    plan_attempts,
)
from egad.stats.clearing import ClearingComparison
from egad.stats.power import needed_attempts


def tried(successes, attempts=20):
    """Attempts at objects with these numbers of successes."""
    rows = [
        (f"{'ABCDEFG'[n % 7]}{n // 7}", "", number, number < won, "")
        for n, won in enumerate(successes)
        for number in range(attempts)
    ]
    return pd.DataFrame(rows, columns=["label", "id", "attempt", "success", "initial_pose"])


def said(one, other):
    first, second = tried(one), tried(other)
    return conclusion("one", "other", compare(first, second), (first, second))


def test_a_difference_that_is_shown_is_told_with_its_size():
    assert said([18] * 10, [14] * 10).startswith("one is better than other by 20.0 percentage")


def test_what_is_not_shown_says_how_many_attempts_would():
    rng = np.random.default_rng(0)
    other = rng.integers(2, 16, size=20)
    text = said(other + rng.integers(-3, 6, size=20), other)
    assert "no difference is shown" in text
    assert re.search(r"about \d+ attempts by each at each object|even 100 attempts", text)


def test_few_objects_get_no_verdict():
    assert "too few objects" in said([20] * 3, [1] * 3)
    assert "better than" not in said([20] * 5, [1] * 5)


def test_equal_detectors_are_told_to_be_equal():
    assert said([5, 10] * 5, [5, 10] * 5).endswith("both succeed equally often")


@pytest.mark.parametrize("difference", [0.15, 0.3])
def test_the_attempts_are_those_of_a_plan(difference):
    rates = ObjectRates(0.6, 0.2, 0.9)
    planned = plan_attempts(15, rates, difference=difference, most=40).attempts
    needed = needed_attempts(15, rates, difference, most=40)
    assert needed == pytest.approx(planned, rel=0.35)


def test_rounds_of_cleared_tables():
    shown = ClearingComparison("pile", "none", 40, 0.1, (0, 0.2), -0.2, (-0.3, -0.1), 0.001)
    text = clearing_conclusion("a", "b", shown)
    assert text.startswith("pile, noise none: b clears 20.0 percentage points more")
    # an interval this wide has a standard error of 5 points over 40 rounds
    unsure = shown._replace(cleared=0.04, cleared_interval=(-0.0624, 0.1424), p_cleared=0.4)
    needed = int(re.search(r"about (\d+) rounds", clearing_conclusion("a", "b", unsure))[1])
    few = unsure._replace(rounds=6, cleared=0.5, cleared_interval=(0, 1))
    assert "a few more rounds" in clearing_conclusion("a", "b", few)
    assert needed == pytest.approx(40 * (2.8 * 0.05 / 0.04) ** 2, rel=0.1)

"""What a comparison shows, in a sentence."""

import re

import numpy as np
import pandas as pd
import pytest
import scipy

from egad.bench.stats import (
    ClearingComparison,
    clearing_conclusion,
    compare,
    conclusion,
)


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
    # Counts vary less over objects than binomial ones: all that varies is the attempts, so that
    # the sample size for two proportions applies: (1.96 + 0.84)^2 * 2 p (1 - p) / difference^2
    text = said([13, 9] * 15, [8, 12] * 15)
    assert "no difference is shown" in text
    at_each = 2.8**2 * 2 * 0.525 * 0.475 / 0.05**2 / 30
    needed = int(re.search(r"about (\d+) attempts by each at each object", text)[1])
    assert needed == pytest.approx(at_each, rel=0.25)
    # half the difference needs four times as many, more than 100
    assert "even 100 attempts at each object would not" in said([13, 9] * 15, [8, 13] * 15)


def test_few_objects_get_no_verdict():
    assert "too few objects" in said([20] * 3, [1] * 3)
    assert "better than" not in said([20] * 5, [1] * 5)


def test_equal_detectors_are_told_to_be_equal():
    assert said([5, 10] * 5, [5, 10] * 5).endswith("both succeed equally often")


SHOWN = ClearingComparison("pile", "none", 40, 0.1, (0, 0.2), -0.2, (-0.3, -0.1), 0.001)
# an interval this wide has a standard error of 5 points over 40 rounds (t = 2.023)
UNSURE = SHOWN._replace(cleared=0.04, cleared_interval=(-0.0624, 0.1424), p_cleared=0.4)


def test_the_better_of_cleared_tables_is_named():
    text = clearing_conclusion("a", "b", SHOWN)
    assert text.startswith("pile, noise none: b clears 20.0 percentage points more")


def test_the_rounds_that_would_show_a_difference_show_it_in_four_of_five_cases():
    needed = int(re.search(r"about (\d+) rounds", clearing_conclusion("a", "b", UNSURE))[1])
    draws = np.random.default_rng(0).normal(0.04, 0.05 * np.sqrt(40), (2000, needed))
    low = scipy.stats.ttest_1samp(draws, 0, axis=1).confidence_interval().low
    assert np.mean(low > 0) == pytest.approx(0.8, abs=0.03)


def test_rounds_have_bounds():
    few = UNSURE._replace(rounds=6, cleared=0.5, cleared_interval=(0, 1))
    assert "a few more rounds" in clearing_conclusion("a", "b", few)
    hardly = UNSURE._replace(cleared=0.001)
    assert clearing_conclusion("a", "b", hardly).endswith("even 1000 rounds would not show it")

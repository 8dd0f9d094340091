"""The evidence that an object is a failure: sharp enough, and wrong in at most 5 % of the cases."""

from collections import defaultdict
from itertools import product

import pytest

from egad.bench.failures.evidence import Claim, PairedDrop

WON, BOTH, NEITHER, LOST = (
    PairedDrop(reference, detector)
    for reference, detector in ((True, False), (True, True), (False, False), (False, True))
)
CLAIM = Claim()


def chance_to_show(claim, chances, most):
    """Exact probability that the claim is ever shown within `most` drops; by counts of outcomes."""
    going, shown = {(0,) * len(chances): 1.0}, 0.0
    outcomes = list(chances)
    for _ in range(most):
        after = defaultdict(float)
        for counts, chance in going.items():
            for number, outcome in enumerate(outcomes):
                new = tuple(count + (i == number) for i, count in enumerate(counts))
                after[new] += chance * chances[outcome]
        going = {}
        for counts, chance in after.items():
            pairs = [o for o, count in zip(outcomes, counts, strict=True) for _ in range(count)]
            if claim.is_shown(pairs):
                shown += chance
            else:
                going[counts] = chance
    return shown


@pytest.mark.parametrize(
    "chances",
    [
        {WON: 0.8, NEITHER: 0.2},  # the reference is just not good enough
        {WON: 0.5, BOTH: 0.5},  # the difference is just too low
        {WON: 0.75, LOST: 0.25},
        {WON: 0.6, BOTH: 0.3, LOST: 0.1},
    ],
)
def test_what_is_no_failure_is_hardly_ever_taken_for_one(chances):
    assert 0 < chance_to_show(CLAIM, chances, 60) < 0.05


def test_a_clear_failure_is_shown_soon():
    assert not CLAIM.is_shown([WON] * 14)
    assert CLAIM.is_shown([WON] * 15)
    assert chance_to_show(CLAIM, {WON: 0.9, BOTH: 0.1}, 24) > 0.9


def test_a_detector_that_succeeds_is_no_failure_however_good_the_reference():
    assert not CLAIM.is_shown([BOTH] * 1000)
    assert not CLAIM.is_shown([])


@pytest.mark.parametrize("most", [4, 5])
def test_hopeless_means_that_no_end_would_show_it(most):
    claim = Claim(0.5, 0.3, 0.6)
    for count in range(most):
        for start in product((WON, BOTH, NEITHER), repeat=count):
            left = most - len(start)
            ends = list(product((WON, BOTH, NEITHER, LOST), repeat=left))
            possible = any(
                claim.is_shown([*start, *end[:n]]) for end in ends for n in range(len(end) + 1)
            )
            assert claim.is_hopeless(start, most) is not possible

"""What a comparison of two detectors shows, in a sentence, and how much data would decide."""

import math
from collections.abc import Sequence

import pandas as pd

from egad.bench.stats.clearing import ClearingComparison
from egad.bench.stats.paired import ENOUGH_OBJECTS, Comparison
from egad.bench.stats.power import fit_object_rates, plan_attempts
from egad.bench.stats.rates import expanded_quantile
from egad.errors import UserError

LEVEL = 0.05
POWER = 0.8
MOST = 100  # attempts at each object that are considered
MOST_ROUNDS = 1000
QUICK_RUNS = 200  # a power of 0.8 then has a standard error of 0.03
FAR = 2.80  # standard errors: a difference this far from 0 is found with the power above


def conclusion(first: str, second: str, result: Comparison, tables: Sequence[pd.DataFrame]) -> str:
    """What two detectors' attempts, the better first, show in words, or how many would."""
    if result.objects < ENOUGH_OBJECTS:
        few = f"too few objects for a test over objects (at least {ENOUGH_OBJECTS})"
        of_these = (
            ""
            if math.isnan(result.p_rates)
            else f"; Boschloo's exact test of these attempts: {_p(result.p_rates)}, for these "
            "objects only"
        )
        return f"{first} vs {second}: {few}{of_these}"
    p = f"{_p(result.p_objects)} over {result.objects} objects"
    if result.p_objects <= LEVEL:
        low, high = (100 * end for end in result.interval)
        interval = f"95 % interval {low:.1f} to {high:.1f}"
        return f"{first} is better than {second} by {_points(result.difference)} ({interval}; {p})"
    shown = f"{first} vs {second}: no difference is shown ({p})"
    if result.difference == 0:
        return f"{shown}: both succeed equally often"
    return f"{shown}; {_more_attempts(result, tables)}"


def _more_attempts(result: Comparison, tables: Sequence[pd.DataFrame]) -> str:
    """How many attempts would show the difference of a comparison."""
    truth = f"if the difference is really {_points(result.difference)}"
    try:
        needed = plan_attempts(
            result.objects,
            fit_object_rates(tables),
            difference=result.difference,
            power=POWER,
            level=LEVEL,
            most=MOST,
            runs=QUICK_RUNS,
        ).attempts
    except UserError:  # rates over objects cannot be estimated
        return f"{truth}, more attempts may show it"
    if needed is None:
        return f"{truth}, even {MOST} attempts at each object would not show it; try more objects"
    if needed * result.objects <= result.attempts:
        return f"{truth}, a few more attempts may show it"
    return (
        f"{truth}, about {needed} attempts by each at each object ({needed * result.objects} in "
        f"all) would show it with a probability of {POWER:g}"
    )


def clearing_conclusion(first: str, second: str, result: ClearingComparison) -> str:
    """What the rounds that two detectors had in common show, for one kind of scene and noise."""
    kind = f"{result.scene}, noise {result.noise}"
    p = f"{_p(result.p_cleared)} over {result.rounds} rounds"
    if result.cleared < 0:
        first, second = second, first
    size, (low, high) = abs(result.cleared), result.cleared_interval
    if result.p_cleared <= LEVEL:
        return f"{kind}: {first} clears {_points(size)} more of the objects than {second} ({p})"
    shown = f"{kind}: no difference between {first} and {second} is shown ({p})"
    if not size or not high > low:  # NaN with a single round
        return shown
    error = (high - low) / 2 / expanded_quantile(result.rounds)
    needed = math.ceil(result.rounds * (FAR * error / size) ** 2)
    shown += f"; if it is really {_points(size)}, "
    if needed > MOST_ROUNDS:
        return f"{shown}even {MOST_ROUNDS} rounds would not show it"
    many = f"about {needed}" if needed > result.rounds else "a few more"
    return f"{shown}{many} rounds would show it"


def _points(difference: float) -> str:
    return f"{100 * difference:.1f} percentage points"


def _p(value: float) -> str:
    return "p < 0.001" if value < 0.001 else f"p = {value:.2g}"

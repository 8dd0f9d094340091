"""What arithmetic can explain: a nudged attempt that ends otherwise, and no altered one."""

from itertools import cycle

import numpy as np
import pandas as pd
import pytest

from egad.bench import Difference, Reproduction
from egad.bench.reproduction import (
    END_TOLERANCE,
    SPREAD_RATIO,
    first_departure,
    judge,
)

ROWS = 200


def table(end_z=0.4, outcome="success"):
    """Attempts that all end the same."""
    return pd.DataFrame(
        {
            "outcome": [outcome] * ROWS,
            "success": [outcome == "success"] * ROWS,
            "lifted": 0.4,
            "stopped": 0.0,
            "end_z": end_z,
        }
    )


def changed(rows, **values):
    """The table with other values in some rows."""
    frame = table()
    for column, value in values.items():
        frame.loc[rows, column] = value
    return frame


def verdict(said, spread=0.0, outcomes=("success",)):
    """The verdict on a table if nudged attempts have some outcomes and end `spread` apart."""
    places = [f"A0, attempt {number}" for number in range(ROWS)]
    turns = cycle(outcomes)
    return judge(
        said,
        table(),
        places,
        lambda _, numbers: table(0.4 + spread, next(turns)).iloc[numbers],
    )


def test_the_same_bits_and_rounding_are_told_apart():
    found = verdict(changed([3, 5], end_z=0.4 + END_TOLERANCE / 2))
    assert found == Reproduction(attempts=ROWS, same=ROWS - 2, close=2)
    assert found.is_honest
    assert found.reasons() == []


@pytest.mark.parametrize(("ratio", "is_explained"), [(0.9, True), (1.1, False)])
def test_another_end_is_explained_if_nudged_attempts_end_about_as_far_apart(ratio, is_explained):
    found = verdict(changed([7], end_z=0.4 + 0.01 * ratio * SPREAD_RATIO), spread=0.01)
    assert len(found.explained) == is_explained
    assert len(found.unexplained) == (not is_explained)
    assert found.is_honest == is_explained


def test_another_outcome_is_explained_only_if_a_nudged_attempt_has_it():
    turned = changed([7], outcome="missed", success=False)
    (found,) = verdict(turned, spread=0.1).unexplained
    assert found == Difference("A0, attempt 7", "outcome", "missed", "success")
    assert str(found) in verdict(turned, spread=0.1).reasons()
    assert len(verdict(turned, spread=0.1, outcomes=("success", "missed")).turned) == 1


def test_as_many_may_differ_as_in_honest_tables():
    """None if all others have the same bits, and of 200 others 3, with 0.4 % expected."""
    assert not verdict(changed([0], end_z=0.5)).is_honest
    some = changed(range(ROWS), end_z=0.4 + END_TOLERANCE / 2)
    some.loc[:2, "end_z"] = 0.5
    assert verdict(some).is_honest
    some.loc[3, "end_z"] = 0.5
    assert not verdict(some).is_honest


def test_a_table_of_which_too_many_results_differ_or_are_skipped_is_refused():
    turned = changed(range(20), outcome="missed", success=False)
    turned.loc[20:, "end_z"] = 0.4 + END_TOLERANCE / 2
    found = verdict(turned, outcomes=("success", "missed"))
    assert len(found.turned) == 20
    assert not found.is_honest
    few = changed(range(8), outcome="missed", success=False)  # as in rounds, whose others are same
    found = verdict(few, outcomes=("success", "missed"))
    assert (found.same, len(found.turned)) == (ROWS - 8, 8)
    assert found.is_honest
    skipped = Reproduction(attempts=ROWS, same=ROWS, skipped=ROWS)
    assert skipped.reasons() == [f"{ROWS} attempts follow one that ended otherwise, more than 30%"]


def test_missing_numbers_agree_only_with_missing_numbers():
    nothing = changed([4], end_z=np.nan)
    assert len(verdict(nothing).unexplained) == 1
    assert first_departure(nothing, table()) == 4
    assert first_departure(nothing, nothing) is None


def test_verdicts_of_several_objects_add_up():
    one, other = verdict(changed([1], end_z=0.5)), verdict(changed([2], lifted=0.1))
    both = one + other
    assert both.attempts == 2 * ROWS
    assert both.unexplained == (*one.unexplained, *other.unexplained)
    assert str(both) == "398 of 400 attempts are the same, 2 end otherwise without a cause"

"""What arithmetic can explain: a nudged attempt that ends otherwise, and no altered one."""

import numpy as np
import pandas as pd
import pytest

from egad.bench import Difference, Reproduction
from egad.bench.reproduction import AMPLE, CHAOTIC, CLOSE, first_departure, judge

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


def verdict(said, spread=0.0):
    """The verdict on a table whose attempts end `spread` apart if they are nudged."""
    places = [f"A0, attempt {number}" for number in range(ROWS)]
    return judge(said, table(), places, lambda _, numbers: table(0.4 + spread).iloc[numbers])


def test_the_same_bits_and_rounding_are_told_apart():
    found = verdict(changed([3, 5], end_z=0.4 + CLOSE / 2))
    assert found == Reproduction(attempts=ROWS, same=ROWS - 2, close=2)
    assert found.is_honest
    assert found.reasons() == []


@pytest.mark.parametrize(
    ("shift", "spread", "is_explained"),
    [
        (0.1, 0.0, False),
        (0.1, 0.9 * CHAOTIC, False),
        (0.1, 1.1 * CHAOTIC, True),
        (CHAOTIC, 1.1 * CHAOTIC / AMPLE, True),
        (CHAOTIC, 0.9 * CHAOTIC / AMPLE, False),
    ],
)
def test_another_end_is_explained_if_nudged_attempts_differ_as_much(shift, spread, is_explained):
    found = verdict(changed([7], end_z=0.4 + shift), spread)
    assert len(found.explained) == is_explained
    assert len(found.unexplained) == (not is_explained)
    assert found.is_honest == is_explained


def test_an_outcome_that_was_turned_is_named_even_if_the_object_ends_in_the_same_place():
    found = verdict(changed([7], outcome="missed", success=False), CHAOTIC / 2)
    assert found.unexplained == (Difference("A0, attempt 7", "outcome", "missed", "success"),)
    assert "A0, attempt 7: outcome is missed, simulated: success" in found.reasons()


def test_one_attempt_in_a_hundred_that_were_rounded_otherwise_may_be_unexplained():
    rounded = 0.4 + CLOSE / 2
    two = changed(range(ROWS), end_z=rounded)
    two.loc[:1, "end_z"] = 0.5
    assert verdict(two).is_honest
    two.loc[2, "end_z"] = 0.5
    assert not verdict(two).is_honest
    assert not verdict(changed([0], end_z=0.5)).is_honest  # all others have the same bits


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
    assert (
        str(both)
        == "398 of 400 attempts are the same to the last bit, 2 end otherwise without a cause"
    )

"""Every outcome is of one kind, and tables keep the names that they always had."""

from egad.outcomes import (
    DETECTOR_FAILURES,
    EXECUTION,
    NOTED_BY_HAND,
    SIMULATION_FAILURES,
    Outcome,
    listed,
)


def test_every_outcome_is_of_one_kind():
    kinds = [*EXECUTION, *SIMULATION_FAILURES, *DETECTOR_FAILURES, *NOTED_BY_HAND]
    assert len(kinds) == len(set(kinds))
    assert set(kinds) == set(Outcome)


def test_outcomes_are_told_as_a_phrase():
    assert listed(SIMULATION_FAILURES) == "failed or crashed"
    assert listed([Outcome.ERROR]) == "error"

"""Every outcome is of one kind, and tables keep the names that they always had."""

from egad.tables.outcomes import (
    DETECTOR_FAILURES,
    EXECUTION,
    NOTED_BY_HAND,
    POSE_FAILURES,
    SHAKEN,
    SIMULATION_FAILURES,
    SUCTION_FAILURES,
    Outcome,
)


def test_every_outcome_is_of_one_kind():
    shaken_only = [outcome for outcome in SHAKEN if outcome not in EXECUTION]
    kinds = [
        *EXECUTION,
        *shaken_only,
        *SUCTION_FAILURES,
        *SIMULATION_FAILURES,
        *POSE_FAILURES,
        *NOTED_BY_HAND,
    ]
    assert [outcome for outcome in SHAKEN if outcome in EXECUTION] == list(EXECUTION)
    assert len(kinds) == len(set(kinds))
    assert set(kinds) == set(Outcome)
    assert set(DETECTOR_FAILURES) < set(POSE_FAILURES)

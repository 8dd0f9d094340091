"""Attempts are repeated from their own beginning: honest tables pass, altered rows are named."""

import numpy as np
import pandas as pd
import pytest
import trimesh
from worlds import EACH_FAST_ENGINE

from egad.bench import NAMED_ERRORS, Reproduction, TrialParameters, TrialProtocol, run_attempts
from egad.bench.reproduction import nudged
from egad.bench.trial_runner import generators, initial_poses
from egad.bench.verified_attempts import EARLIER, UNKNOWN, verify_attempts
from egad.detectors.registry import QUICK
from egad.geometry import Bundle
from egad.grippers import GRIPPERS
from egad.sim.model import build
from egad.sim.parameters import EngineName
from egad.tables.columns import INITIAL

COUNT = 8
MODEL = build(trimesh.creation.cylinder(0.02, 0.07), 400.0, Bundle())


def settings(engine: EngineName = "mujoco", **trials: object) -> TrialParameters:
    protocol = TrialProtocol(
        attempts=COUNT,
        engine=engine,
        errors=NAMED_ERRORS["typical"],
        lift_height=0.1,
        hold_time=0.2,
    )
    return TrialParameters(
        seed=3, gripper=GRIPPERS["egad_75mm"], trials=protocol.model_copy(update=trials)
    )


def run(model=MODEL, detector="antipodal-depth", **trials) -> pd.DataFrame:
    return run_attempts(model, "A0", "cylinder", QUICK[detector], settings(**trials))


@pytest.fixture(scope="module")
def table() -> pd.DataFrame:
    """Successes and failures, each attempt beginning where the one before ended."""
    found = run(detector="random")
    assert 0 < found["success"].sum() < COUNT
    return found


@EACH_FAST_ENGINE
@pytest.mark.parametrize("detector", ["random", "antipodal-depth"])
def test_a_table_is_reproduced_to_the_last_bit(engine, detector):
    found = run(detector=detector, engine=engine)
    assert verify_attempts(MODEL, found, settings(engine)) == Reproduction(COUNT, same=COUNT)


@EACH_FAST_ENGINE
@pytest.mark.parametrize("by", [3e-14, -2e-13])
def test_a_table_that_was_rounded_otherwise_is_honest(engine, by):
    found = run(nudged(MODEL, by), engine=engine)
    verdict = verify_attempts(MODEL, found, settings(engine))
    assert verdict.same < COUNT
    assert verdict.is_honest
    assert verdict.attempts == COUNT


def turned(table: pd.DataFrame, row: int) -> pd.DataFrame:
    """A failure is said to be a success."""
    table = table.copy()
    table.loc[row, ["success", "outcome"]] = True, "success"
    return table


def last_failure(table: pd.DataFrame) -> int:
    return int(np.flatnonzero(~table["success"])[-1])


def test_a_turned_outcome_is_named_and_so_is_what_does_not_follow_from_it(table):
    first = int(np.flatnonzero(~table["success"])[0])
    verdict = verify_attempts(MODEL, turned(table, first), settings())
    assert [each.place for each in verdict.unexplained] == [f"A0, attempt {first}"]
    if first + 1 < COUNT:  # after a success, the hand drops the object
        assert [each.simulated for each in verdict.impossible] == [UNKNOWN]
    assert not verdict.is_honest


def test_a_turned_outcome_with_the_end_of_a_success_is_named(table):
    row, success = last_failure(table), int(np.flatnonzero(table["success"])[0])
    forged = turned(table, row)
    ends = ["lifted", *(column for column in table if column.startswith("end_"))]
    forged.loc[row, ends] = table.loc[success, ends]
    verdict = verify_attempts(MODEL, forged, settings())
    assert f"A0, attempt {row}" in [each.place for each in verdict.unexplained]
    assert not verdict.is_honest


def test_attempts_at_another_object_are_refused(table):
    other = build(trimesh.creation.box((0.03, 0.05, 0.04)), 400.0, Bundle())
    assert len(other.parts) == len(MODEL.parts)
    assert not verify_attempts(other, table, settings()).is_honest


def test_an_initial_pose_must_follow_from_the_seed_and_the_attempt_before(table):
    moved = table.assign(initial_x=table["initial_x"].where(table.index != 0, 0.01))
    (found,) = verify_attempts(MODEL, moved, settings()).impossible
    assert (found.place, found.simulated) == ("A0, attempt 0", UNKNOWN)


def test_a_drop_that_the_protocol_would_not_come_to_is_told():
    """The drops after the first one are only for objects that roll away."""
    found = run(reset="redrop")
    seed = int(found["seed"][0], 16)
    poses = list(initial_poses(MODEL.mesh, None, generators(seed)[0]))
    second = [*poses[1].pose.position, *poses[1].pose.quaternion]
    for column, number in zip(INITIAL, second, strict=True):
        found.loc[0, column] = number
    verdict = verify_attempts(MODEL, found, settings(reset="redrop"))
    assert EARLIER in [each.simulated for each in verdict.unexplained]


@pytest.mark.parametrize(
    ("column", "value"),
    [("seed", "1f" * 16), ("contact", "close"), ("parts", 9), ("errors", "none"), ("width", 0.2)],
)
def test_values_that_settings_and_hand_rule_out_are_named(table, column, value):
    row = int(np.flatnonzero(table["width"].notna())[0])
    forged = table.copy()
    forged.loc[row, column] = value
    (found,) = verify_attempts(MODEL, forged, settings()).impossible
    assert found.place == f"A0, attempt {row}"


def test_an_attempt_without_an_initial_pose_cannot_be_checked(table):
    blank = table.assign(initial_pose=table["initial_pose"].where(table.index != 1, ""))
    (found,) = verify_attempts(MODEL, blank, settings()).impossible
    assert (found.place, found.said) == ("A0, attempt 1", "missing")


def test_a_detector_cannot_be_said_to_have_failed_with_a_grasp_or_succeeded_without(table):
    row = last_failure(table)
    failed = table.copy()
    failed.loc[row, "outcome"] = "no_grasp"
    without = turned(table, row)
    without.loc[row, "width"] = np.nan
    for forged in (failed, without):
        (found,) = verify_attempts(MODEL, forged, settings()).impossible
        assert (found.place, found.column) == (f"A0, attempt {row}", "outcome")

"""Attempts at one object beside the same attempts simulated again, each from its initial pose."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import takewhile

import numpy as np
import pandas as pd

from egad._util.arrays import Ints
from egad.bench.attempts import END, columns_of, failed_attempts, read_attempt
from egad.bench.parameters import TrialParameters
from egad.bench.reproduction import Difference, Reproduction, judge, nudged
from egad.bench.runner import Attempt, InitialPose
from egad.bench.trial_runner import TrialRunner, drop_generator
from egad.sim import ARMS, Model, Pose, open_world
from egad.tables import parquet
from egad.tables.outcomes import DETECTOR_FAILURES, Outcome

# columns that settings, seed and model determine, whatever the attempts come to
GIVEN = ["label", "id", "attempt", "seed", "calibration", "errors", "contact", "engine", "parts"]
ROUNDING = 1e-9  # metres and parts of a quaternion, of poses before any contact
UNKNOWN = "does not follow from the seed and the attempt before"
SKIPPED = "an earlier one comes to rest"


def verify_attempts(model: Model, rows: pd.DataFrame, settings: TrialParameters) -> Reproduction:
    """Make all attempts of `TRIALS` at an object again, and tell altered ones from rounding."""
    rows = rows.reset_index(drop=True)
    given = {"attempts": len(rows), "engine": rows["engine"].iloc[0]}
    settings = settings.model_copy(update={"trials": settings.trials.model_copy(update=given)})
    places = [f"{rows['label'].iloc[0]}, attempt {number}" for number in rows["attempt"]]
    if impossible := tuple(_contradictions(model, rows, settings, places)):
        return Reproduction(len(rows), impossible=impossible)
    repeats = list(_repeat(model, rows, settings))
    flaws = {
        flaw: tuple(
            Difference(place, "initial_pose", kind, flaw)
            for place, kind, (_, found) in zip(places, rows["initial_pose"], repeats, strict=True)
            if found == flaw
        )
        for flaw in (UNKNOWN, SKIPPED)
    }

    def again(by: float, numbers: Ints) -> pd.DataFrame:
        some = rows.iloc[numbers]
        return _table(some, list(_repeat(nudged(model, by), some, settings)))

    verdict = judge(rows, _table(rows, repeats), places, again)
    return verdict + Reproduction(unexplained=flaws[SKIPPED], impossible=flaws[UNKNOWN])


def _contradictions(
    model: Model, rows: pd.DataFrame, settings: TrialParameters, places: list[str]
) -> Iterator[Difference]:
    """Values that settings, seed and model rule out, and grasps that no hand would try."""
    label, name = rows["label"].iloc[0], rows["id"].iloc[0]
    given = failed_attempts(label, name, settings, Outcome.FAILED).assign(parts=len(model.parts))
    for column in GIVEN:
        for number in np.flatnonzero(rows[column].to_numpy() != given[column].to_numpy()):
            yield Difference(places[number], column, rows[column][number], given[column][number])
    for place, row in zip(places, parquet.records(rows), strict=True):
        if not row["initial_pose"]:
            continue
        _, grasp, _ = read_attempt(row, settings.trials.errors)
        flaw = Outcome.NO_GRASP if grasp is None else grasp.infeasibility(settings.gripper)
        if (flaw is None) == (row["outcome"] in DETECTOR_FAILURES):
            yield Difference(place, "outcome", row["outcome"], flaw or "a grasp that was tried")


def _repeat(
    model: Model, rows: pd.DataFrame, settings: TrialParameters
) -> Iterator[tuple[Attempt, str]]:
    """Each attempt again from its recorded initial pose, and the flaw of that, if any."""
    arm = ARMS[settings.trials.arm](settings.gripper)
    with open_world(settings.trials.engine, [model], arm.robot) as world:
        runner = TrialRunner(world, arm, settings.trials)
        before = None
        for row in parquet.records(rows):
            start, grasp, deviation = read_attempt(row, settings.trials.errors)
            runner.vary(deviation)
            if not row["initial_pose"]:
                began = runner.begin(drop_generator(int(row["seed"], 16)))
                again, flaw = Attempt(None if began else Outcome.FAILED), ""
            else:
                flaw = _flaw(runner, start, int(row["seed"], 16), before)
                again = runner.repeat(start, grasp, deviation)
            yield again, flaw
            end = Pose.of([row[name] for name in END])
            before = replace(again, outcome=Outcome(row["outcome"]), end=end)


def _flaw(runner: TrialRunner, start: InitialPose, seed: int, before: Attempt | None) -> str:
    """Why an initial pose does not follow from a seed and the attempt before; empty if it does."""
    # Whether the object had moved is a matter of rounding where it moved by just `MOVED`.
    is_clear = before is None or before.outcome == Outcome.SUCCESS
    for left in (before,) if is_clear else (before, None):
        poses = list(runner.starts(drop_generator(seed), left))
        earlier = list(takewhile(lambda pose: not _equal(pose, start), poses))
        if len(earlier) < len(poses):
            return SKIPPED if any(runner.rest_from(each) for each in earlier) else ""
    return UNKNOWN


def _equal(first: InitialPose, second: InitialPose) -> bool:
    one, two = (np.concatenate(each.pose) for each in (first, second))
    return first.kind == second.kind and bool(np.allclose(one, two, rtol=0.0, atol=ROUNDING))


def _table(rows: pd.DataFrame, repeats: list[tuple[Attempt, str]]) -> pd.DataFrame:
    """What attempts came to; why there was no grasp is known from the table alone."""
    found = pd.DataFrame([columns_of(attempt) for attempt, _ in repeats])
    untold = (found["outcome"] == "").to_numpy() & rows["outcome"].isin(DETECTOR_FAILURES)
    return found.assign(outcome=np.where(untold, rows["outcome"], found["outcome"]))

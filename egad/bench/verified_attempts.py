"""Attempts at one object beside the same attempts simulated again, each from its initial pose."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import takewhile

import numpy as np
import pandas as pd

from egad._util.arrays import Ints
from egad.bench.attempts import END, columns_of, failed_attempts, read_attempt
from egad.bench.parameters import TrialParameters
from egad.bench.reproduction import Difference, Reproduction, differing, judge, nudged
from egad.bench.runner import Attempt, InitialPose
from egad.bench.trial_runner import TrialRunner, generators
from egad.sim import ARMS, Model, Pose, open_world
from egad.tables import parquet
from egad.tables.outcomes import DETECTOR_FAILURES, SIMULATION_FAILURES, Outcome

# columns that settings, seed and model determine, whatever the attempts come to
DETERMINED = ["label", "id", "attempt", "seed", "calibration", "errors", "contact", "engine"]
ROUNDING = 1e-9  # metres and parts of a quaternion, of poses before any contact
UNKNOWN = "does not follow from the seed and the attempt before"
EARLIER = "an earlier one comes to rest"


def verify_attempts(model: Model, rows: pd.DataFrame, settings: TrialParameters) -> Reproduction:
    """Make all attempts of `TRIALS` at an object again, and tell altered ones from rounding."""
    rows = rows.reset_index(drop=True)
    changes = {"attempts": len(rows), "engine": rows["engine"].iloc[0]}
    settings = settings.model_copy(update={"trials": settings.trials.model_copy(update=changes)})
    places = [f"{rows['label'].iloc[0]}, attempt {number}" for number in rows["attempt"]]
    if impossible := tuple(_contradictions(model, rows, settings, places)):
        return Reproduction(len(rows), impossible=impossible)
    attempts, flaws = zip(*_repeat(model, rows, settings), strict=True)
    unlike: dict[str, list[Difference]] = {flaw: [] for flaw in (UNKNOWN, EARLIER)}
    for place, kind, flaw in zip(places, rows["initial_pose"], flaws, strict=True):
        if flaw:
            unlike[flaw].append(Difference(place, "initial_pose", kind, flaw))

    def simulate_nudged(fraction: float, numbers: Ints) -> pd.DataFrame:
        some = rows.iloc[numbers]
        repeated = _repeat(nudged(model, fraction), some, settings, alone=True)
        return _table(some, [attempt for attempt, _ in repeated])

    judged = judge(rows, _table(rows, attempts), places, simulate_nudged)
    return judged + Reproduction(
        unexplained=tuple(unlike[EARLIER]), impossible=tuple(unlike[UNKNOWN])
    )


def _contradictions(
    model: Model, rows: pd.DataFrame, settings: TrialParameters, places: list[str]
) -> Iterator[Difference]:
    """Values that settings, seed and model rule out, and grasps that no hand would try."""
    label, name = rows["label"].iloc[0], rows["id"].iloc[0]
    determined = failed_attempts(label, name, settings, Outcome.FAILED)
    yield from differing(rows, determined[DETERMINED].assign(parts=len(model.parts)), places)
    for place, row in zip(places, parquet.records(rows), strict=True):
        is_failure, outcome = row["outcome"] in DETECTOR_FAILURES, row["outcome"]
        if not row["initial_pose"]:
            if outcome not in SIMULATION_FAILURES:
                yield Difference(place, "initial_pose", "missing", "needed to repeat the attempt")
            continue
        _, grasp, _ = read_attempt(row, settings.trials.errors)
        flaw = None if grasp is None else grasp.infeasibility(settings.gripper)
        if flaw or is_failure != (grasp is None):
            tried = "no grasp" if grasp is None else "a grasp"
            yield Difference(place, "outcome", outcome, flaw or f"{tried} was tried")


def _repeat(
    model: Model, rows: pd.DataFrame, settings: TrialParameters, *, alone: bool = False
) -> Iterator[tuple[Attempt, str]]:
    """Each attempt again from its recorded initial pose, and the flaw of that, if any.

    Attempts `alone`, without those before them, have no flaw.
    """
    arm = ARMS[settings.trials.arm](settings.gripper)
    with open_world(settings.trials.engine, [model], arm.robot) as world:
        runner = TrialRunner(world, arm, settings.trials)
        before = None
        for row in parquet.records(rows):
            initial, grasp, deviation = read_attempt(row, settings.trials.errors)
            seed, flaw = int(row["seed"], 16), ""
            runner.vary(deviation)
            if not row["initial_pose"]:
                began = not alone and runner.begin(generators(seed)[0], before)
                repeated = Attempt(None if began else Outcome.FAILED)
            else:
                flaw = "" if alone else _flaw(runner, initial, seed, before)
                repeated = runner.repeat(initial, grasp, deviation)
            yield repeated, flaw
            end = Pose.of([row[name] for name in END])
            before = replace(
                repeated,
                outcome=Outcome(row["outcome"]),
                end=end if np.isfinite(end.position).all() else None,
            )


def _flaw(runner: TrialRunner, initial: InitialPose, seed: int, before: Attempt | None) -> str:
    """Why an initial pose does not follow from a seed and the attempt before; empty if it does."""
    # Rounding decides whether an object has moved if it moved by nearly the least distance.
    unsure = before is not None and runner.barely_moved(before)
    for previous in (before, None) if unsure else (before,):
        poses = list(runner.initial_poses(generators(seed)[0], previous))
        earlier = list(takewhile(lambda pose: not _equal(pose, initial), poses))
        if len(earlier) < len(poses):
            return EARLIER if any(runner.rest_from(each) for each in earlier) else ""
    return UNKNOWN


def _equal(first: InitialPose, second: InitialPose) -> bool:
    one, two = (np.concatenate(each.pose) for each in (first, second))
    return first.kind == second.kind and bool(np.allclose(one, two, rtol=0.0, atol=ROUNDING))


def _table(rows: pd.DataFrame, attempts: Iterable[Attempt]) -> pd.DataFrame:
    """What attempts came to; why there was no grasp is known from the table alone."""
    table = pd.DataFrame([columns_of(attempt) for attempt in attempts])
    without_reason = (table["outcome"] == "").to_numpy() & rows["outcome"].isin(DETECTOR_FAILURES)
    return table.assign(outcome=np.where(without_reason, rows["outcome"], table["outcome"]))

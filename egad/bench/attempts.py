"""All attempts at an object as rows of a table, and attempts read back from rows."""

import logging
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple, TypeVar

import numpy as np
import pandas as pd

from egad.bench.cell_errors import SESSION, Deviation, draw
from egad.bench.parameters import CellErrors, TrialParameters
from egad.bench.runner import Attempt, InitialPose
from egad.bench.trial_runner import TrialRunner
from egad.detectors import Detector, Grasp, Labels
from egad.errors import UserError
from egad.random import entropy
from egad.sim import ARMS, Model, Pose, open_world, platform_of
from egad.tables.columns import INITIAL, POSE_PARTS
from egad.tables.evaluation import TRIALS
from egad.tables.outcomes import Outcome

CENTER = ("grasp_x", "grasp_y", "grasp_z")
NUMBERS = ("angle", "width", "depth", "quality")
log = logging.getLogger(__name__)
Item = TypeVar("Item")
ENGINE_TIME = 60.0  # seconds; an attempt takes less than one, unless the engine hangs
END = tuple(f"end_{part}" for part in POSE_PARTS)


def run_attempts(
    model: Model, label: str, object_id: str, detect: Detector | Labels, settings: TrialParameters
) -> pd.DataFrame:
    """Attempts at an object as in EGAD, section V: `TRIALS`; id and seed determine all."""
    seeds = _seeds(object_id, settings)
    known = {"parts": len(model.parts), "volume_error": model.volume_error}
    arm = ARMS[settings.trials.arm](settings.gripper)
    with open_world(settings.trials.engine, [model], arm.robot) as world:
        runner = TrialRunner(world, arm, settings.trials)
        attempts = list(_chain(runner, detect, seeds, settings.trials.errors))
    return _table(label, object_id, seeds, attempts, known | _protocol(settings))


def failed_attempts(
    label: str, object_id: str, settings: TrialParameters, outcome: Outcome
) -> pd.DataFrame:
    """The table of an object that cannot be simulated: all attempts have the same outcome."""
    seeds = _seeds(object_id, settings)
    attempts = [Attempt(outcome)] * len(seeds)
    known = {"parts": 0, "volume_error": np.nan}
    return _table(label, object_id, seeds, attempts, known | _protocol(settings))


def read_attempt(
    row: Mapping[str, Any], errors: CellErrors
) -> tuple[InitialPose, Grasp | None, Deviation]:
    """Initial pose, grasp and deviation of a row of `tables.evaluation.TRIALS` that began."""
    start = InitialPose(row["initial_pose"], Pose.of([row[name] for name in INITIAL]))
    deviation = draw(errors, *(_hexadecimal(row, name) for name in ("calibration", "seed")))
    if np.isnan(row["width"]):
        return start, None, deviation
    x, y, z = (float(row[name]) for name in CENTER)
    return start, Grasp((x, y, z), *(float(row[key]) for key in NUMBERS)), deviation


def _hexadecimal(row: Mapping[str, Any], name: str) -> int:
    try:
        return int(row[name], 16)
    except ValueError as error:
        place = f"{row['label']}, attempt {row['attempt']}"
        raise UserError(
            f"{place}: {name} is {row[name]!r}; allowed: a hexadecimal number"
        ) from error


def _protocol(settings: TrialParameters) -> dict[str, str]:
    trials = settings.trials
    return {
        "engine": trials.engine,
        "platform": platform_of(trials.engine),
        "errors": str(trials.errors),
        "contact": trials.contact,
    }


class _Seeds(NamedTuple):
    """The seeds of an attempt and of the calibration before it."""

    attempt: int
    calibration: int


def _seeds(object_id: str, settings: TrialParameters) -> list[_Seeds]:
    return [
        _Seeds(
            entropy(settings.seed, "trial", object_id, number),
            entropy(settings.seed, "session", object_id, number // SESSION),
        )
        for number in range(settings.trials.attempts)
    ]


def _chain(
    runner: TrialRunner, detect: Detector | Labels, seeds: list[_Seeds], errors: CellErrors
) -> Iterator[Attempt]:
    """Make attempts, each of which continues where the previous one ended."""
    before = None
    for seed, calibration in seeds:
        before = runner.attempt(detect, seed, before, draw(errors, calibration, seed))
        yield before


def _table(
    label: str, object_id: str, seeds: list[_Seeds], attempts: list[Attempt], known: dict[str, Any]
) -> pd.DataFrame:
    known = known | {"label": label, "id": object_id}
    rows = [
        known
        | {"attempt": number, "seed": f"{seed:032x}", "calibration": f"{calibration:032x}"}
        | columns_of(attempt)
        for number, ((seed, calibration), attempt) in enumerate(zip(seeds, attempts, strict=True))
    ]
    return pd.DataFrame(rows, columns=TRIALS.names)


def columns_of(attempt: Attempt) -> dict[str, Any]:
    """The columns of `tables.evaluation.TRIALS` that an attempt determines."""
    grasp, start = attempt.grasp, attempt.start
    return {
        **attempt.columns(),
        "initial_pose": start.kind if start else "",
        **dict(zip(INITIAL, _numbers(start.pose if start else None), strict=True)),
        **dict(zip(CENTER, grasp.center if grasp else (np.nan,) * 3, strict=True)),
        **{name: getattr(grasp, name) if grasp else np.nan for name in NUMBERS},
        "lifted": attempt.lifted,
        **dict(zip(END, _numbers(attempt.end), strict=True)),
    }


def _numbers(pose: Pose | None) -> list[float]:
    if pose is None:
        return [np.nan] * len(POSE_PARTS)
    return [*pose.position.tolist(), *pose.quaternion.tolist()]


def run_or_replace(
    row: Mapping[str, Any],
    work: Callable[[Item], pd.DataFrame | None],
    item: Item | None,
    otherwise: Callable[[Outcome], pd.DataFrame],
) -> pd.DataFrame:
    """The table of the work on an object; if there is none, or no item, that of the outcome."""
    table = None if item is None else work(item)
    if table is not None:
        return table
    outcome = Outcome.FAILED if item is None else Outcome.CRASHED
    log.warning("%s (%s): everything %s", row["label"], row["id"], outcome)
    return otherwise(outcome)

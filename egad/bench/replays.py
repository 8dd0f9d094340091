"""Repeating attempts and rounds of tables without their detector, as films."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from egad._util.arrays import RgbImage
from egad._util.progress import phase_if_slow
from egad.bench.attempts import END, columns_of, read_attempt
from egad.bench.parameters import ClutterParameters, TrialParameters
from egad.bench.reproduction import END_TOLERANCE
from egad.bench.rounds import Models, film_round
from egad.bench.runner import Attempt
from egad.bench.trial_runner import TrialRunner
from egad.errors import UserError
from egad.sim import ARMS, Film, open_world, write_film
from egad.tables import parquet
from egad.tables.clutter import CLUTTER
from egad.tables.evaluation import TRIALS


@phase_if_slow("simulating and filming the attempt")
def film_attempt(
    settings: TrialParameters, trials: Path, models: Models, label: str, attempt: int, out: Path
) -> str:
    """Repeat an attempt of `TRIALS`, film it (`.gif`, `.mp4`), and return its outcome."""
    row = _row(trials, label, attempt)
    if not row["initial_pose"]:
        raise UserError(f"{label}, attempt {attempt} never started: {row['outcome']}")
    again, frames = repeat_attempt(settings, row, models)
    write_film(frames, out)
    _check(row, columns_of(again))
    return str(row["outcome"])


def repeat_attempt(
    settings: TrialParameters, row: Mapping[str, Any], models: Models
) -> tuple[Attempt, list[RgbImage]]:
    """Repeat an attempt that started, a row of TRIALS: its outcome and the frames of its film."""
    if row["id"] not in models:
        raise UserError(f"no object {row['label']} ({row['id']}) in this dataset")
    arm = ARMS[settings.trials.arm](settings.gripper)
    with open_world(row["engine"], [models[row["id"]]], arm.robot) as world:
        film = Film(world)
        again = TrialRunner(world, arm, settings.trials).repeat(
            *read_attempt(row, settings.trials.errors)
        )
    return again, film.frames


def _row(trials: Path, label: str, attempt: int) -> dict[str, Any]:
    table = parquet.read(trials, TRIALS)
    own = table[table["label"] == label]
    if len(own) == 0:
        names = ", ".join(table["label"].unique())
        raise UserError(f"{trials}: no object {label}; allowed: {names}")
    found = parquet.records(own[own["attempt"] == attempt])
    if not found:
        raise UserError(f"{trials}: {label} has no attempt {attempt}; its last is {len(own) - 1}")
    return found[0]


def _check(row: Mapping[str, Any], again: Mapping[str, Any]) -> None:
    """Check for the same outcome, if there was a grasp, and the same final pose."""
    outcome = again["outcome"] or row["outcome"]
    before, after = ([values[name] for name in END] for values in (row, again))
    if outcome != row["outcome"] or not np.allclose(
        np.array(before), np.array(after), rtol=0.0, atol=END_TOLERANCE, equal_nan=True
    ):
        raise UserError(
            f"{row['label']}, attempt {row['attempt']} was not reproduced: {outcome}, not "
            f"{row['outcome']}; settings, bundle, machine or the version of {row['engine']} must "
            "differ from those of the trials"
        )


def film_clearing(
    settings: ClutterParameters, table: Path, models: Models, name: tuple[str, str, int], out: Path
) -> None:
    """Repeat a round (kind of scene, noise, number) without its detector, and film it."""
    write_film(film_round(parquet.read(table, CLUTTER), *name, models, settings), out)

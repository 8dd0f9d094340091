"""Films of what trials recorded: an attempt, or a round of clearing a table."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from egad._util.progress import phase_if_slow
from egad.cli.common import (
    FIRST_TARGET,
    RUN,
    Config,
    DatasetIn,
    gripper_option,
    named_gripper,
    out_option,
    settings_in,
)
from egad.errors import UserError, check_name
from egad.perception import NoiseName, SceneKind

if TYPE_CHECKING:
    from egad._util.arrays import RgbImage
    from egad.config.stages import SimulatedTrials
    from egad.sim import Attempt, ClutterParameters

RunGripper = Annotated[str | None, gripper_option(FIRST_TARGET, opening=False)]


def replay(
    label: Annotated[str, typer.Argument(help="label in the evaluation set, such as C4")],
    attempt: Annotated[int, typer.Argument(help="number of the attempt, from 0")],
    out: Annotated[
        Path | None, out_option("film to write: .gif or .mp4; default: LABEL-ATTEMPT.gif")
    ] = None,
    dataset: DatasetIn = RUN,
    gripper: RunGripper = None,
    detector: Annotated[
        str | None, typer.Option(help="detector; default: the first of targets.detectors")
    ] = None,
    table: Annotated[
        Path | None, typer.Option(help="table of other attempts at the objects of this dataset")
    ] = None,
    config: Config = None,
) -> None:
    """Repeat a simulated attempt exactly, and film it."""
    from egad.config.stages import SimulatedTrials, select
    from egad.io import check_ending
    from egad.sim import ENDINGS

    path = out or Path(f"{label}-{attempt}.gif")
    check_ending(path, ENDINGS)
    settings = settings_in(config)
    hand = named_gripper(settings, gripper)
    detector = detector or settings.targets.detectors[0]
    check_name("--detector", detector, settings.detectors, " in the configuration (--config)")
    outcome = film_attempt(
        select(settings, SimulatedTrials, hand, detector),
        table or dataset / "trials" / hand / f"{detector}.parquet",
        dataset / "bundle" / hand,
        label,
        attempt,
        path,
    )
    typer.echo(f"{path}: {label}, attempt {attempt}: {outcome}, as before")


def film(
    scene: Annotated[SceneKind, typer.Argument(help="kind of scene")],
    number: Annotated[int, typer.Argument(help="number of the round, from 0")],
    noise: Annotated[NoiseName, typer.Option(help="noise of the depth images")] = "none",
    out: Annotated[
        Path | None, out_option("film to write: .gif or .mp4; default: SCENE-NUMBER.gif")
    ] = None,
    dataset: DatasetIn = RUN,
    gripper: RunGripper = None,
    detector: Annotated[
        str | None, typer.Option(help="detector; default: the first of targets.clutter")
    ] = None,
    config: Config = None,
) -> None:
    """Repeat a round of clearing a table exactly, and film it."""
    from egad.config.stages import select
    from egad.io import check_ending
    from egad.sim import ENDINGS, ClutterParameters

    path = out or Path(f"{scene}-{number}.gif")
    check_ending(path, ENDINGS)
    settings = settings_in(config)
    hand = named_gripper(settings, gripper)
    if detector is None and not settings.targets.clutter:
        raise UserError("--detector is missing: the configuration has no targets.clutter")
    film_clearing(
        select(settings, ClutterParameters, hand),
        dataset / "clutter" / hand / f"{detector or settings.targets.clutter[0]}.parquet",
        dataset / "bundle" / hand,
        (scene, noise, number),
        path,
    )
    typer.echo(f"{path}: round {number} of {scene}, noise {noise}, as before")


@phase_if_slow("simulating and filming the attempt")
def film_attempt(
    settings: "SimulatedTrials", trials: Path, bundle: Path, label: str, attempt: int, out: Path
) -> str:
    """Repeat an attempt and film it.

    The detector does not run again: its proposal is in the table.

    Args:
        settings: Settings of the trials.
        trials: Table with the columns of `tables.evaluation.TRIALS`.
        bundle: Folder of the simulation bundle.
        label: The object.
        attempt: Number of the attempt.
        out: Film to write, `.gif` or `.mp4`.

    Returns:
        The outcome.

    Raises:
        UserError: There is no such attempt, it never started, or its outcome differs.
    """
    from egad.sim import columns_of, write_film

    row = _row(trials, label, attempt)
    if not row["initial_pose"]:
        raise UserError(f"{label}, attempt {attempt} never started: {row['outcome']}")
    again, frames = repeat_attempt(settings, row, bundle)
    write_film(frames, out)
    _check(row, columns_of(again))
    return str(row["outcome"])


def repeat_attempt(
    settings: "SimulatedTrials", row: Mapping[str, Any], bundle: Path
) -> "tuple[Attempt, list[RgbImage]]":
    """The outcome of a repeated attempt, and the frames of its film.

    Args:
        settings: Settings of the trials.
        row: Columns of `tables.evaluation.TRIALS`, of an attempt that started.
        bundle: Folder of the simulation bundle.
    """
    from egad.sim import ARMS, Film, TrialRunner, open_world, read_attempt
    from egad.workflow.bundled import model_in, rows_by_id

    known = rows_by_id(bundle)
    if row["id"] not in known:
        raise UserError(f"{bundle}: no object {row['label']}")
    arm = ARMS[settings.trials.arm](settings.gripper)
    with open_world(row["engine"], [model_in(bundle, known[row["id"]])], arm.robot) as world:
        film = Film(world)
        again = TrialRunner(world, arm, settings.trials).repeat(
            *read_attempt(row, settings.trials.errors)
        )
    return again, film.frames


def _row(trials: Path, label: str, attempt: int) -> dict[str, Any]:
    from egad.tables import parquet
    from egad.tables.evaluation import TRIALS

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
    """The same outcome, if there was a grasp to repeat, and the same end, bit by bit."""
    import numpy as np

    from egad.sim import END

    outcome = again["outcome"] or row["outcome"]
    before, after = ([values[name] for name in END] for values in (row, again))
    if outcome != row["outcome"] or not np.array_equal(before, after, equal_nan=True):
        raise UserError(
            f"{row['label']}, attempt {row['attempt']} was not reproduced: {outcome}, not "
            f"{row['outcome']}; settings, bundle, machine or the version of {row['engine']} must "
            "differ from those of the trials"
        )


def film_clearing(
    settings: "ClutterParameters",
    table: Path,
    bundle: Path,
    name: tuple[str, str, int],
    out: Path,
) -> None:
    """Repeat a round without its detector, and film it.

    Args:
        settings: Settings of the rounds.
        table: Columns of `tables.clutter.CLUTTER`.
        bundle: Folder of the simulation bundle.
        name: Kind of scene, noise and number of the round.
        out: Film to write, `.gif` or `.mp4`.

    Raises:
        UserError: There is no such round, or it ends differently.
    """
    from egad.sim import film_round, write_film
    from egad.tables import parquet
    from egad.tables.clutter import CLUTTER
    from egad.workflow.bundled import model_in, rows_by_id

    models = {each: model_in(bundle, row) for each, row in rows_by_id(bundle).items()}
    write_film(film_round(parquet.read(table, CLUTTER), *name, models, settings), out)

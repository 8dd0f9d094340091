"""Films of what trials recorded: an attempt, or a round of clearing a table."""

from pathlib import Path
from typing import Annotated

import typer

from egad.bench import SceneKind
from egad.cli import common
from egad.cli.repeat import RunGripper, SimulatedIn, repeatable_in
from egad.detectors import NoiseName
from egad.errors import UserError


def replay(
    label: Annotated[str, typer.Argument(help="label in the evaluation set, such as C4")],
    attempt: Annotated[int, typer.Argument(help="number of the attempt, from 0")],
    out: Annotated[
        Path | None, common.out_option("film to write: .gif or .mp4; default: LABEL-ATTEMPT.gif")
    ] = None,
    dataset: SimulatedIn = None,
    gripper: RunGripper = None,
    detector: Annotated[
        str | None, typer.Option(help="detector; default: the first of targets.detectors")
    ] = None,
    table: Annotated[
        Path | None, typer.Option(help="table of other attempts at the objects of this dataset")
    ] = None,
    config: common.Config = None,
) -> None:
    """Repeat a simulated attempt exactly, and film it."""
    from egad.bench import TrialParameters, film_attempt
    from egad.io import check_ending
    from egad.sim import ENDINGS
    from egad_workflow.settings import select

    path = out or Path(f"{label}-{attempt}.gif")
    check_ending(path, ENDINGS)
    table, settings, hand, models = repeatable_in(
        "trials", detector, table, dataset, gripper, config
    )
    parameters = select(settings, TrialParameters, hand)
    outcome = film_attempt(parameters, table, models, label, attempt, path)
    typer.echo(f"{path}: {label}, attempt {attempt}: {outcome}, as before")


def film(
    scene: Annotated[SceneKind, typer.Argument(help="kind of scene")],
    number: Annotated[int, typer.Argument(help="number of the round, from 0")],
    noise: Annotated[NoiseName, typer.Option(help="noise of the depth images")] = "none",
    out: Annotated[
        Path | None, common.out_option("film to write: .gif or .mp4; default: SCENE-NUMBER.gif")
    ] = None,
    dataset: SimulatedIn = None,
    gripper: RunGripper = None,
    detector: Annotated[
        str | None, typer.Option(help="detector; default: the first of targets.clutter")
    ] = None,
    table: Annotated[
        Path | None, typer.Option(help="table of other rounds with the objects of this dataset")
    ] = None,
    config: common.Config = None,
) -> None:
    """Repeat a round of clearing a table exactly, and film it."""
    from egad.bench import ClutterParameters, film_clearing
    from egad.io import check_ending
    from egad.sim import ENDINGS
    from egad.tables import parquet
    from egad_workflow.settings import select

    path = out or Path(f"{scene}-{number}.gif")
    check_ending(path, ENDINGS)
    if table is not None and "scene" not in parquet.columns(table):
        raise UserError(
            f"{table} is of trials, not of cleared tables; film an attempt with "
            f"`egad trials replay LABEL ATTEMPT --table {table}`"
        )
    table, settings, hand, models = repeatable_in(
        "clutter", detector, table, dataset, gripper, config
    )
    parameters = select(settings, ClutterParameters, hand)
    film_clearing(parameters, table, models, (scene, noise, number), path)
    typer.echo(f"{path}: round {number} of {scene}, noise {noise}, as before")

"""The commands that train grasp networks, and compare what they learnt from."""

from pathlib import Path
from typing import Annotated

import typer

from egad.errors import UserError
from egad.pipeline.cli.common import (
    CORES,
    STAGE,
    Config,
    Jobs,
    Out,
    OutFolder,
    app,
    changed,
    parse,
    settings_in,
)
from egad.pipeline.cli.recorded import recorded
from egad.pipeline.cli.stages import SettingsText


@app.command(rich_help_panel=STAGE)
def train(
    images: Annotated[Path, typer.Argument(help="folder of rendered images")],
    out: OutFolder,
    network: Annotated[str | None, typer.Option(help="ggcnn or ggcnn2; else the settings")] = None,
    seed: Annotated[int | None, typer.Option(help="all chance; else the settings")] = None,
    budget: Annotated[
        int | None, typer.Option(min=1, help="most images to learn from; else the settings")
    ] = None,
    config: Config = None,
    settings: Annotated[
        str | None, typer.Option(help="settings of this stage, as JSON, in the place of --config")
    ] = None,
    jobs: Jobs = CORES,
) -> None:
    """Train a grasp network on rendered images: weights, history, chart and model card.

    If it is interrupted, the same command goes on after the last epoch, with the same result.
    """
    from egad.pipeline.config.check import check
    from egad.pipeline.config.stage_settings import TrainNetwork, select
    from egad.pipeline.stages import train as stage

    if settings is not None:
        if config or network or seed is not None or budget:
            raise UserError("--settings has all settings; leave the other ones away")
        parsed = parse(TrainNetwork, settings)
    else:
        whole = changed(settings_in(config), "training", network=network, images=budget)
        if seed is not None:
            whole = check({**whole.model_dump(mode="json"), "seed": seed})
        parsed = select(whole, TrainNetwork)
    with recorded("train", parsed, [images], stage.files(out)):
        score = stage.run(parsed, images, out, jobs)
    typer.echo(
        f"{out}: right in {score.right} of {score.count} images of held-out objects, "
        f"{score.rate:.0%} ({score.interval[0]:.0%} to {score.interval[1]:.0%})"
    )


@app.command(rich_help_panel=STAGE)
def diversity(
    settings: SettingsText,
    gripper: Annotated[str, typer.Option(help="name of the gripper of the trials")],
    results: Annotated[Path, typer.Option(help="folder of all results")],
    out: Out,
    table: Annotated[Path, typer.Option(help="table of all attempts to write")],
    reads: Annotated[
        list[Path] | None, typer.Argument(help="what it shows, for the record")
    ] = None,
) -> None:
    """Put networks side by side that learnt from different objects."""
    from egad.pipeline.config.stage_settings import DiversityReport
    from egad.pipeline.stages import diversity as stage

    parsed = parse(DiversityReport, settings)
    with recorded("diversity", parsed, reads or [], [out], gripper=gripper):
        stage.run(parsed, gripper, results, out, table)

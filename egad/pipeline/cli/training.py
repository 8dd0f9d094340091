"""The command that trains grasp networks."""

from pathlib import Path
from typing import Annotated

import typer

from egad.errors import UserError
from egad.pipeline.cli.common import (
    CORES,
    Config,
    Jobs,
    OutFolder,
    app,
    changed,
    parse,
    settings_in,
)
from egad.pipeline.cli.stages import PANEL


@app.command(rich_help_panel=PANEL)
def train(
    images: Annotated[list[Path], typer.Argument(help="folders of rendered images, as one set")],
    out: OutFolder,
    network: Annotated[
        str | None, typer.Option(help="ggcnn or ggcnn2; default: as in the settings")
    ] = None,
    seed: Annotated[
        int | None, typer.Option(help="random seed; default: as in the settings")
    ] = None,
    budget: Annotated[
        int | None,
        typer.Option(min=1, help="number of training examples; default: as in the settings"),
    ] = None,
    config: Config = None,
    settings: Annotated[
        str | None, typer.Option(help="settings of this stage, as JSON, instead of --config")
    ] = None,
    jobs: Jobs = CORES,
) -> None:
    """Train a grasp network on rendered images: weights, history, chart and model card.

    After an interruption, the same command resumes after the last epoch, with the same result.
    """
    from egad.pipeline.config.check import check
    from egad.pipeline.config.stage_settings import select
    from egad.pipeline.provenance.record import run_recorded
    from egad.pipeline.stages.train import TrainNetwork, run

    if settings is not None:
        if config or network or seed is not None or budget:
            raise UserError("--settings has all settings; omit the other options")
        parsed = parse(TrainNetwork, settings)
    else:
        whole = changed(settings_in(config), "training", network=network, images=budget)
        if seed is not None:
            whole = check({**whole.model_dump(mode="json"), "seed": seed})
        parsed = select(whole, TrainNetwork)
    score = run_recorded(run, settings=parsed, images=images, out=out, jobs=jobs)
    typer.echo(
        f"{out}: correct in {score.n_correct} of {score.n_images} images of held-out objects, "
        f"{score.rate:.0%} ({score.interval[0]:.0%} to {score.interval[1]:.0%})"
    )

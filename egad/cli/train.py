"""Training of grasp networks."""

from pathlib import Path
from typing import Annotated

import typer

from egad.cli.common import CORES, Config, Jobs, OutFolder, settings_in, with_option
from egad.learning import NetworkName


def train(
    images: Annotated[list[Path], typer.Argument(help="folders of rendered images, as one set")],
    out: OutFolder,
    network: Annotated[
        NetworkName | None, typer.Option(help="default: as in the configuration")
    ] = None,
    seed: Annotated[
        int | None, typer.Option(min=0, help="random seed; default: as in the configuration")
    ] = None,
    budget: Annotated[
        int | None,
        typer.Option(min=1, help="number of training examples; default: as in the configuration"),
    ] = None,
    config: Config = None,
    jobs: Jobs = CORES,
) -> None:
    """Train a grasp network on rendered images: weights, history, chart and model card.

    After an interruption, the same command resumes after the last epoch, with the same result.
    """
    from egad.config.stages import TrainNetwork, select
    from egad.io import write_sums
    from egad.provenance.record import recorded
    from egad.workflow.train import CARD, CHART, WEIGHTS
    from egad.workflow.train import train as train_network

    whole = with_option(settings_in(config), "--network", "training.network", network)
    whole = with_option(whole, "--budget", "training.images", budget)
    whole = with_option(whole, "--seed", "seed", seed)
    settings = select(whole, TrainNetwork)
    with recorded("train", settings=settings, inputs=images):
        score = train_network(settings, images, out, jobs)
        for name in (WEIGHTS, CHART, CARD):
            write_sums(out / name)
    typer.echo(
        f"{out}: correct in {score.n_correct} of {score.n_images} images of held-out objects, "
        f"{score.rate:.0%} ({score.interval[0]:.0%} to {score.interval[1]:.0%})"
    )

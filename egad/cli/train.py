"""Training of grasp networks."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from egad.cli import common
from egad.errors import UserError
from egad.learning import NetworkName
from egad_workflow.settings import Settings


def train(
    folders: Annotated[
        list[Path],
        typer.Argument(help="folders of rendered images, or of scenes for vgn, used as one set"),
    ],
    out: common.OutFolder,
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
    start: Annotated[
        Path | None,
        typer.Option(
            exists=True,
            dir_okay=False,
            help="initial weights, from an earlier training or published; default: random ones",
        ),
    ] = None,
    device: Annotated[
        Literal["cpu", "cuda"],
        typer.Option(
            help="device that vgn is trained on; on a GPU, the last digits may differ each time"
        ),
    ] = "cpu",
    config: common.Config = None,
    jobs: common.Jobs = common.CORES,
) -> None:
    """Train a grasp network on rendered images or scenes: weights, history, chart, model card.

    After an interruption, the same command resumes after the last epoch, with the same result.
    """
    options = {
        "--network": ("training.network", network),
        "--seed": ("seed", seed),
        "--budget": ("training.examples", budget),
    }
    whole = common.settings_in(config, options)
    scenes = whole.training.network == "vgn"
    if not scenes and device != "cpu":
        raise UserError(f"--device {device} is for the network vgn; others train on the CPU")
    if scenes:
        told = _on_scenes(whole, folders, out, jobs, device, start)
    else:
        told = _on_images(whole, folders, out, jobs, start)
    typer.echo(f"{out}: {told}")


def _on_images(
    whole: Settings, folders: list[Path], out: Path, jobs: int, start: Path | None
) -> str:
    """Train on images; returns the result in words."""
    from egad.io import write_sums
    from egad.learning import TrainNetwork
    from egad.learning.train_on_images import FOR_PEOPLE
    from egad.learning.train_on_images import train as train_network
    from egad_workflow.code_version import code_version
    from egad_workflow.provenance import recorded
    from egad_workflow.settings import select

    settings = select(whole, TrainNetwork)
    with recorded("train", settings=settings, inputs=_inputs(folders, start)):
        code = "-".join(map(code_version, ("egad.detectors.networks", "egad.learning.training")))
        score = train_network(settings, folders, out, jobs, start, code)
        for name in FOR_PEOPLE:
            write_sums(out / name)
    return (
        f"correct in {score.n_correct} of {score.n_images} images of held-out objects, "
        f"{score.rate:.0%} ({score.interval[0]:.0%} to {score.interval[1]:.0%})"
    )


def _on_scenes(
    whole: Settings, folders: list[Path], out: Path, jobs: int, device: str, start: Path | None
) -> str:
    """Train on scenes, of whichever gripper; returns the result in words."""
    from egad.io import write_sums
    from egad.learning import TrainOnScenes
    from egad.learning.train_on_images import FOR_PEOPLE
    from egad.learning.train_on_scenes import open_scenes, train_on_scenes
    from egad_workflow.code_version import code_version
    from egad_workflow.provenance import recorded
    from egad_workflow.settings import select

    scenes = open_scenes(folders)
    name = scenes.gripper_name
    whole = whole.model_copy(update={"grippers": {**whole.grippers, name: scenes.gripper}})
    settings = select(whole, TrainOnScenes, name)
    inputs = _inputs(folders, start)
    with recorded("train", settings=settings, arguments={"device": device}, inputs=inputs):
        code = code_version("egad.learning.train_on_scenes")
        score = train_on_scenes(settings, name, folders, out, jobs, device, start, code)
        for file in FOR_PEOPLE:
            write_sums(out / file)
    low, high = score.average_precision.interval
    return (
        f"average precision {score.average_precision.value:.2f} ({low:.2f} to {high:.2f}) at "
        f"{score.grasps} grasps in {score.scenes} scenes of held-out objects; "
        f"{score.share:.0%} of the grasps succeeded"
    )


def _inputs(folders: list[Path], start: Path | None) -> list[Path]:
    return folders if start is None else [*folders, start]

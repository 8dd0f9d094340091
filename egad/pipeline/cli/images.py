"""Commands of the stages that render images and describe them."""

from pathlib import Path
from typing import Annotated

import typer

from egad.perception.parameters import RenderParameters
from egad.pipeline.cli.common import STAGE, Out, app, parse
from egad.pipeline.cli.recorded import recorded
from egad.pipeline.cli.stages import Rejected, SettingsText, Shard, Shards

Grasps = Annotated[Path, typer.Option(help="labelled grasps")]


@app.command(rich_help_panel=STAGE)
def render(
    settings: SettingsText,
    shard: Shard,
    shards: Shards,
    objects: Annotated[Path, typer.Option(help="objects of the dataset")],
    meshes: Annotated[Path, typer.Option(help="folder of the scaled meshes")],
    grasps: Grasps,
    out: Out,
    rejected: Rejected,
    evaluation: Annotated[
        Path | None, typer.Option("--eval", help="evaluation set, to hold out")
    ] = None,
) -> None:
    """Render the depth images of a shard, with the grasps that can be reached in them."""
    from egad.pipeline.stages import render as stage

    parsed = parse(RenderParameters, settings)
    reads = [objects, meshes, grasps, *([evaluation] if evaluation else [])]
    with recorded("render", parsed, reads, shard=shard, shards=shards):
        stage.run(parsed, objects, meshes, grasps, evaluation, (shard, shards), out, rejected)


@app.command(name="image-card", rich_help_panel=STAGE)
def image_card(
    settings: SettingsText,
    dataset: Annotated[str, typer.Option(help="name of the dataset")],
    gripper: Annotated[str, typer.Option(help="name of the gripper")],
    images: Annotated[Path, typer.Option(help="folder of the images")],
    shards: Shards,
    rejects: Annotated[list[Path], typer.Option(help="rejected objects of the shards")],
    out: Out,
    rejected: Rejected,
) -> None:
    """Write the card of a set of images: counts, splits, camera, noise."""
    from egad.pipeline.stages import image_card as stage

    parsed = parse(RenderParameters, settings)
    found = stage.tidy(images, shards)
    reads = [*found, *rejects]
    with recorded("image_card", parsed, reads, [out], dataset=dataset, gripper=gripper):
        stage.run(parsed, dataset, gripper, found, rejects, out, rejected)

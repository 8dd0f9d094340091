"""Exports of labelled grasps and of images with them in the formats of other programs."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated, TypeVar

import typer

from egad.errors import UserError
from egad.pipeline.cli.common import TOOL, Config, Out, app, parse, settings_in
from egad.pipeline.cli.recorded import recorded
from egad.pipeline.config.stage_settings import (
    AcronymFiles,
    DexNetDatabase,
    DexNetObjects,
    ImageLayouts,
    StageSettings,
    select,
)

S = TypeVar("S", bound=StageSettings)
Dataset = Annotated[Path, typer.Argument(help="folder of a dataset, e.g. results/egad")]
Parts = Annotated[list[Path], typer.Option("--part", help="objects of a shard (dexnet)")]


class Format(StrEnum):
    """The formats."""

    DEXNET = "dexnet"
    ACRONYM = "acronym"
    JACQUARD = "jacquard"
    CORNELL = "cornell"
    GQCNN = "gqcnn"


@app.command(rich_help_panel=TOOL)
def export(
    dataset: Dataset,
    gripper: Annotated[str, typer.Option(help="name of the gripper")],
    out: Out,
    ending: Annotated[Format, typer.Option("--format", help="whose format")],
    config: Config = None,
    settings: Annotated[str | None, typer.Option(help="settings of the stage, as JSON")] = None,
    part: Parts = [],  # noqa: B006 (typer copies it)
) -> None:
    """Write labelled grasps for Dex-Net or ACRONYM, or rendered images in other layouts."""
    from egad.exchange.grasps import check_opening, grasp_table

    if ending in (Format.JACQUARD, Format.CORNELL, Format.GQCNN):
        layouts = _chosen(ImageLayouts, settings, config, gripper)
        check_opening(dataset, gripper, layouts.gripper.opening)
        _images(layouts, ending.value, dataset / "images" / gripper, out)
        return
    grasps = grasp_table(dataset, gripper)
    if ending is Format.DEXNET:
        database = _chosen(DexNetDatabase, settings, config, gripper)
        check_opening(dataset, gripper, database.gripper.opening)
        _dexnet(database, dataset, gripper, part, config, grasps, out)
    else:
        files = _chosen(AcronymFiles, settings, config, gripper)
        check_opening(dataset, gripper, files.gripper.opening)
        _acronym(files, dataset, gripper, grasps, out)


def _dexnet(
    settings: DexNetDatabase,
    dataset: Path,
    gripper: str,
    parts: list[Path],
    config: Path | None,
    grasps: Path,
    out: Path,
) -> None:
    """Join the parts that are given; without any, make one first."""
    from egad.pipeline.stages import dexnet as stage
    from egad.pipeline.stages import dexnet_objects

    objects, meshes = dataset / "objects.parquet", dataset / "rescaled" / gripper
    if out.is_dir():
        raise UserError(f"--out {out} is a folder; name a file")
    if out.suffix != ".hdf5":
        raise UserError(f"--out {out}: the name must end in .hdf5, else Dex-Net does not open it")
    reads = [objects, meshes, grasps]
    if parts:
        with recorded("dexnet", settings, [*reads, *parts], [out], gripper=gripper):
            stage.run(settings, dataset, gripper, parts, grasps, out)
        return
    stage.check(dataset, gripper, grasps)
    whole = out.with_name(f".{out.name}.objects")
    try:
        dexnet_objects.run(_chosen(DexNetObjects, None, config), objects, meshes, (0, 1), whole)
        with recorded("dexnet", settings, reads, [out], gripper=gripper):
            stage.run(settings, dataset, gripper, [whole], grasps, out)
    finally:
        whole.unlink(missing_ok=True)


def _acronym(settings: AcronymFiles, dataset: Path, gripper: str, grasps: Path, out: Path) -> None:
    from egad.exchange.acronym import is_ours
    from egad.pipeline.stages import acronym as stage

    _check_folder(out)
    if foreign := [path.name for path in sorted(out.glob("*")) if not is_ours(path)]:
        raise UserError(
            f"--out {out}: {foreign[0]} is no earlier export and would be lost; "
            "name a folder of its own"
        )
    scales = dataset / "rescaled" / gripper / "scales.parquet"
    objects = dataset / "objects.parquet"
    with recorded("acronym", settings, [objects, scales, grasps], [out], gripper=gripper):
        stage.run(settings, gripper, objects, scales, grasps, out)


def _images(settings: ImageLayouts, layout: str, images: Path, out: Path) -> None:
    from egad.perception.image_shards import files
    from egad.pipeline.stages import image_layout as stage

    _check_folder(out)
    if out.is_dir() and any(out.iterdir()):
        raise UserError(f"--out {out} is not empty, and what is in it would be lost")
    with recorded("image_layout", settings, files(images), [out], layout=layout):
        stage.run(settings, layout, images, out)


def _check_folder(out: Path) -> None:
    if out.is_file():
        raise UserError(f"--out {out} is a file; name a folder")


def _chosen(stage: type[S], text: str | None, config: Path | None, gripper: str | None = None) -> S:
    """The settings of a stage: those handed over, or the part of a configuration."""
    if text is not None:
        return parse(stage, text)
    whole = settings_in(config)
    if gripper is not None and gripper not in whole.grippers:
        raise UserError(
            f"gripper {gripper!r} is not in the configuration (--config); "
            f"known: {', '.join(whole.grippers)}"
        )
    return select(whole, stage, gripper)

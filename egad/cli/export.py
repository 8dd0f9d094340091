"""Exports of objects, labelled grasps and images in the formats of other programs."""

from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Any

import typer

from egad.cli import common
from egad.errors import UserError
from egad.exchange import (
    ALL,
    EVALUATION_SET,
    OBJECT_FORMATS,
    Format,
    ObjectSet,
    last_files,
    settings_class,
    sources,
    write_format,
)
from egad.grippers import GRIPPERS
from egad_workflow.settings import Settings

Dataset = Annotated[
    Path,
    typer.Argument(
        help="folder of a dataset, e.g. results/egad; `released` or `evaluation-set`; or an "
        "archive.parquet"
    ),
]
RELEASED = "released"


def export(
    dataset: Dataset,
    gripper: Annotated[str, common.gripper_option()],
    out: Annotated[Path, common.out_option("file or folder to write, depending on the format")],
    format_name: Annotated[Format, typer.Option("--format", help="format to write")],
    config: common.Config = None,
    objects: Annotated[
        ObjectSet | None,
        typer.Option(
            help="which objects to write (formats of objects)", show_default="evaluation-set"
        ),
    ] = None,
) -> None:
    """Export objects for simulators and browsers, labelled grasps, or rendered images."""
    from egad.exchange import check_opening, grasp_table
    from egad.io import write_sums
    from egad_workflow.provenance import recorded
    from egad_workflow.settings import select

    if dataset.is_file() or str(dataset) in (RELEASED, EVALUATION_SET):
        if objects and str(dataset) != RELEASED:
            raise UserError(f"--objects is only for the folder of a run, not for {dataset}")
        _export_archive(dataset, gripper, out, format_name, config, objects)
        return
    chosen = objects or EVALUATION_SET
    reads = {name: dataset / file for name, file in sources(format_name, gripper, chosen).items()}
    if format_name in OBJECT_FORMATS:
        # not an opening: results have names
        common.named_gripper(common.settings_in(config), gripper)
        _check_made(dataset / file for file in last_files(format_name, gripper, chosen))
    for name in reads.keys() & {"grasps", "simulated_grasps"}:
        reads[name] = grasp_table(dataset, gripper)
    whole, _ = common.named_gripper(common.settings_in(config), gripper)
    check_opening(dataset, gripper, whole.grippers[gripper].opening)
    settings = select(whole, settings_class(format_name, chosen), gripper)
    arguments = {"gripper": gripper, "format": format_name, "objects": objects}
    with recorded("export", settings=settings, inputs=reads.values(), arguments=arguments):
        if format_name == "dexnet":
            _write_dexnet(settings, whole, dataset, gripper, reads["grasps"], out)
        else:
            write_format(format_name, chosen, settings, gripper, reads, out)
        write_sums(out)


def _export_archive(
    archive: Path,
    gripper: str,
    out: Path,
    format_name: str,
    config: Path | None,
    objects: str | None,
) -> None:
    """Write objects that no run has scaled or grasped yet, as `egad.export` does."""
    from egad.exchange import needs_run
    from egad.exchange.export import export
    from egad.objects import load

    if needs_run(format_name):
        folder = Path("results/egad")
        files = " ".join(str(folder / file) for file in last_files(format_name, gripper))
        shipped = " --configfile config/released.yaml --" if not archive.is_file() else ""
        raise UserError(
            f"{archive} contains only objects, but {format_name} needs results of a run; first "
            f"make them with snakemake --cores 2{shipped} {files}, then export {folder}"
        )
    settings, name = common.gripper_in(common.settings_in(config), gripper)
    hand = name if config is None and name in GRIPPERS else settings.grippers[name]
    whole = str(archive) != RELEASED or objects == ALL
    export(load(str(archive) if whole else EVALUATION_SET), format_name, hand, out)


def _check_made(files: Iterable[Path]) -> None:
    for file in files:
        if not file.exists():
            raise UserError(f"{file} is missing; make it first: snakemake --cores 2 {file}")


def _write_dexnet(
    settings: Any,  # noqa: ANN401 (of the format)
    whole: Settings,
    dataset: Path,
    gripper: str,
    grasps: Path,
    out: Path,
) -> None:
    """Write a Dex-Net database, doing at once what the workflow does in shards."""
    from egad.exchange import DexNetObjects
    from egad.exchange.dexnet_database import write_objects
    from egad.exchange.grasps import dexnet
    from egad.tables import parquet
    from egad.tables.objects import OBJECTS
    from egad_workflow.settings import select

    if out.is_dir():
        raise UserError(f"--out {out} is a folder; name a file")
    if out.suffix != ".hdf5":
        raise UserError(
            f"--out {out}: the name must end in .hdf5, otherwise Dex-Net does not open it"
        )
    dexnet.check_names(dataset, gripper, grasps)
    part = out.with_name(f".{out.name}.objects")
    try:
        meshes = dataset / "rescaled" / gripper
        wanted = select(whole, DexNetObjects)
        rows = parquet.records(parquet.read(dataset / "objects.parquet", OBJECTS))
        write_objects(wanted, rows, meshes, part)
        dexnet.run(settings, dataset, gripper, [part], grasps, out)
    finally:
        part.unlink(missing_ok=True)

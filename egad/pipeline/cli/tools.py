"""Tools that write files: scaled meshes, the meshes of an archive, pictures."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from egad.errors import UserError
from egad.pipeline.cli.common import (
    CORES,
    TOOL,
    Config,
    Jobs,
    Meshes,
    Out,
    OutFolder,
    Rule,
    Units,
    app,
    files_in,
    parse,
    settings_in,
)
from egad.pipeline.config import Settings

ArchiveFile = Annotated[Path, typer.Argument(help="archive.parquet, or `released`")]


@app.command(rich_help_panel=TOOL)
def rescale(
    meshes: Meshes,
    out: OutFolder,
    settings: Annotated[str | None, typer.Option(help="settings of the stage, as JSON")] = None,
    opening: Annotated[float | None, typer.Option(help="opening of the gripper, metres")] = None,
    rule: Rule = "paper",
    units: Units = None,
    ending: Annotated[str, typer.Option("--format", help="obj (m) or stl (mm)")] = "obj",
    jobs: Jobs = CORES,
) -> None:
    """Scale meshes to a gripper."""
    from egad.geometry import scale_suffix
    from egad.pipeline.config.check import check
    from egad.pipeline.config.stage_settings import select
    from egad.pipeline.provenance.record import run_recorded
    from egad.pipeline.stages.rescale import WRITERS, RescaleMeshes, run

    if settings is not None:
        parsed = parse(RescaleMeshes, settings)
    elif opening is not None:
        grippers = {**Settings().model_dump()["grippers"], "yours": {"opening": opening}}
        config = {"grippers": grippers, "rescale": {"rule": rule}}
        parsed = select(check(config), RescaleMeshes, "yours")
    else:
        raise UserError("rescale needs --opening, the widest opening of the gripper in metres")
    if f".{ending}" not in WRITERS:
        allowed = ", ".join(each[1:] for each in WRITERS)
        raise UserError(f"--format is {ending!r}; allowed: {allowed}")
    suffix = ""
    if settings is None:  # otherwise from the pipeline: its folder may be empty
        meshes, suffix = files_in(meshes, units), scale_suffix(rule, parsed.gripper.opening)
        _spare(out, meshes)
    rejected = run_recorded(
        run,
        settings=parsed,
        meshes=meshes,
        units=units if settings is None else units or "m",  # the pipeline writes metres
        out=out,
        ending=ending,
        suffix=suffix,
        jobs=jobs,
    )
    if rejected:
        typer.echo(f"{rejected} files were rejected: see {out / 'rejected.parquet'}")


@app.command(rich_help_panel=TOOL)
def bundle(
    meshes: Meshes,
    out: OutFolder,
    settings: Annotated[str | None, typer.Option(help="settings of the stage, as JSON")] = None,
    evaluation: Annotated[
        Path | None,
        typer.Option(
            "--eval", help="evaluation set; MESHES is then the folder of its scaled meshes"
        ),
    ] = None,
    units: Units = None,
    config: Config = None,
    jobs: Jobs = CORES,
) -> None:
    """Prepare meshes for simulators: convex parts, URDF, MJCF, poses at rest."""
    from egad.pipeline.config.stage_settings import select
    from egad.pipeline.provenance.record import run_recorded
    from egad.pipeline.stages import bundle as stage

    if settings is not None:
        parsed = parse(stage.SimulationBundle, settings)
    else:
        parsed = select(settings_in(config), stage.SimulationBundle)
    if evaluation is not None:
        if len(meshes) != 1 or not meshes[0].is_dir():
            raise UserError("bundle --eval takes one folder of meshes, those of the evaluation set")
    else:
        meshes = files_in(meshes, units)
    if settings is None:
        folder = sorted(meshes[0].iterdir()) if evaluation else meshes
        _spare(out, folder, "bundle.parquet")
    rejected = run_recorded(
        stage.bundle,
        settings=parsed,
        evaluation=evaluation,
        meshes=meshes,
        units=units if settings is None else units or "m",  # the pipeline writes metres
        out=out,
        jobs=jobs,
    )
    if rejected:
        typer.echo(f"{rejected} objects were rejected: see {out / 'rejected.parquet'}")


@app.command(rich_help_panel=TOOL)
def export_meshes(
    archive: ArchiveFile,
    out: OutFolder,
    resolution: Annotated[
        int | None,
        typer.Option(help="voxels along each side, 8 to 200; default: those of the archive"),
    ] = None,
    objects: Annotated[
        list[str] | None,
        typer.Option("--object", help="label or id; may be repeated; default: all objects"),
    ] = None,
    config: Config = None,
    jobs: Jobs = CORES,
) -> None:
    """Write the meshes of an archive as ID.obj, in metres, without repair."""
    from functools import partial

    from egad.cppn import check_resolution
    from egad.data import archive_path
    from egad.map_elites import EvolutionParameters
    from egad.objects import load
    from egad.pipeline.archive_settings import check_provenance
    from egad.pipeline.config.stage_settings import LocateMeshes, select
    from egad.pipeline.stages import export_meshes as stage
    from egad.pipeline.stages.evolve import rules_of

    _spare(out)
    archive, settings = archive_path(archive), settings_in(config)
    if archive.is_dir() and not (archive / "archive.parquet").is_file():
        raise UserError(f"{archive} has no archive.parquet: its objects come from meshes")
    if resolution is not None:
        check_resolution(resolution)
    archive = archive / "archive.parquet" if archive.is_dir() else archive
    check_provenance(archive, select(settings, LocateMeshes), ("shape",))
    ids = None if objects is None else load(archive).select(objects).table["id"].tolist()
    rules = partial(rules_of, select(settings, EvolutionParameters))
    count = stage.run(archive, out, settings.shape, resolution, rules, ids, jobs)
    typer.echo(f"{count} meshes in {out}")


@app.command(rich_help_panel=TOOL)
def genome(
    name: Annotated[str, typer.Argument(help="label or id of an object, or id of an ancestor")],
    source: Annotated[
        str,
        typer.Option("--in", help="`released`, archive.parquet, or folder of a dataset"),
    ] = "released",
    out: Annotated[Path | None, typer.Option(help="drawing to write: .svg")] = None,
    digits: Annotated[
        int | None,
        typer.Option(min=1, max=17, help="significant digits; default: as many as shapes need"),
    ] = None,
    config: Config = None,
) -> None:
    """Print the network that an object was grown from as expressions, or draw it."""
    from egad._util.files import write_text
    from egad.cppn import genome_text
    from egad.objects import load
    from egad.report.genome_drawing import genome_svg

    if out is not None and out.suffix != ".svg":
        raise UserError(f"--out is {out}; allowed: a file that ends in .svg")
    objects, settings = load(source), settings_in(config)
    if name not in objects and name in objects.lineage:
        row = objects.lineage.genome(name)
    else:
        row = objects[name].genome
    if out is not None:
        write_text(out, genome_svg(row))
        return
    regions = {each: getattr(settings, each) for each in ("envelope", "keep_solid", "hole")}
    shape, symmetry = objects.shape, settings.symmetry
    text = genome_text(row, digits=digits, shape=shape, symmetry=symmetry, regions=regions)
    typer.echo(text, nl=False)


@app.command(rich_help_panel=TOOL)
def collage(
    dataset: Annotated[Path, typer.Argument(help="folder of a dataset, e.g. results/egad")],
    out: Out,
    config: Config = None,
) -> None:
    """Draw the objects of a dataset, arranged in the space, as one PNG picture."""
    from egad.pipeline.stages import collage as stage

    settings = settings_in(config)
    stage.run(dataset, out, settings.space, settings.measures)


@app.command(rich_help_panel=TOOL)
def heatmap(archive: ArchiveFile, out: Out, config: Config = None) -> None:
    """Draw the number of elites per cell of an archive, as SVG."""
    from egad._util.files import write_text
    from egad.data import archive_path
    from egad.measures import MeasureParameters, attainable_difficulty
    from egad.pipeline.archive_settings import check_provenance
    from egad.pipeline.config.stage_settings import LocateMeshes, select
    from egad.report.axes import axis_pair
    from egad.report.comparison import dataset_maps
    from egad.tables import parquet
    from egad.tables.evolution import ARCHIVE

    settings = settings_in(config)
    check_provenance(archive_path(archive), select(settings, LocateMeshes), ("space",))
    objects = parquet.read(archive_path(archive), ARCHIVE)
    limit = attainable_difficulty(select(settings, MeasureParameters))
    axes = axis_pair(settings.measures)
    maps = dataset_maps({archive.stem: objects}, settings.space, axes, limit.rows)
    write_text(out, maps)


@app.command(name="check-config", rich_help_panel=TOOL)
def check_config(files: list[Path]) -> None:
    """Check configuration files and list all problems."""
    for file in files:
        settings_in(file)
        typer.echo(f"{file}: fine")


def _spare(folder: Path, files: Sequence[Path] = (), table: str = "scales.parquet") -> None:
    """Raise UserError if a folder has files that this command did not write."""
    foreign = folder.exists() and any(folder.iterdir()) and not (folder / table).exists()
    inside = any(folder.resolve() in file.resolve().parents for file in files)
    if foreign or inside:
        raise UserError(f"--out {folder} has other files, which would be lost; give another folder")

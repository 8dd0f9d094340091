"""The `egad` command: one command a stage, and tools for people."""

import logging
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, TypeVar

import typer
import yaml
from pydantic import BaseModel, ValidationError

from egad.errors import RejectedError, UserError
from egad.settings import Settings
from egad.tables import TableError

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    help="Evolved objects for robot grasping. Commands take metres unless they say otherwise.",
)
M = TypeVar("M", bound=BaseModel)

SettingsText = Annotated[str, typer.Option("--settings", help="settings of this stage, as JSON")]
Out = Annotated[Path, typer.Option(help="file to write")]
OutFolder = Annotated[Path, typer.Option(help="folder to write")]
Shard = Annotated[int, typer.Option(help="number of this shard")]
Shards = Annotated[int, typer.Option(help="number of all shards")]
Rejected = Annotated[Path, typer.Option(help="table of the objects left out, with reasons")]
Config = Annotated[Path | None, typer.Option(help="configuration file; else the defaults")]
STAGE = "Stages of the pipeline"
TOOL = "Tools"


def main() -> None:
    """Run the command; say what went wrong in a sentence, without a traceback."""
    logging.basicConfig(level=logging.INFO, format="%(message)s", stream=sys.stderr)
    try:
        app()
    except (UserError, TableError, RejectedError) as error:
        sys.exit(f"egad: {error}")
    except OSError as error:
        sys.exit(f"egad: {error.strerror or error}: {error.filename or ''}".rstrip(": "))


def _parse(model: type[M], text: str) -> M:
    try:
        return model.model_validate_json(text)
    except ValidationError as error:
        raise UserError(f"--settings is not what this stage reads: {error}") from error


def _settings(config: Path | None) -> Settings:
    """The settings of a configuration file; the defaults without one."""
    from egad.config_check import check

    if config is None:
        return Settings()
    try:
        values = yaml.safe_load(config.read_text(encoding="utf-8"))
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise UserError(f"{config}: not a YAML file: {error}") from error
    return check(values or {})


def _spare(folder: Path, files: Sequence[Path] = ()) -> None:
    """Refuse to replace a folder that holds anything but what this command wrote before."""
    foreign = folder.exists() and any(folder.iterdir()) and not (folder / "scales.parquet").exists()
    inside = any(folder.resolve() in file.resolve().parents for file in files)
    if foreign or inside:
        raise UserError(f"--out {folder} holds files that would be lost; name a folder of its own")


@app.command(rich_help_panel=STAGE)
def evolve(
    settings: SettingsText,
    epoch: Annotated[int, typer.Option(help="number of the epoch")],
    island: Annotated[int, typer.Option(help="number of the island")],
    out: Out,
    base: Annotated[Path | None, typer.Option(help="archive of the epoch before")] = None,
    jobs: Annotated[int, typer.Option(min=1, help="processes")] = 1,
) -> None:
    """Evolve one island for one epoch."""
    from egad.stage_settings import Evolve
    from egad.stages import evolve as stage

    stage.run(_parse(Evolve, settings), epoch, island, base, out, jobs)


@app.command(rich_help_panel=STAGE)
def merge(settings: SettingsText, islands: list[Path], out: Out) -> None:
    """Merge the islands of an epoch into one archive."""
    from egad.stage_settings import Merge
    from egad.stages import merge as stage

    stage.run(_parse(Merge, settings), islands, out)


@app.command(rich_help_panel=STAGE)
def archive(epoch_archive: Path, out: Out) -> None:
    """Publish the archive of the last epoch."""
    from egad.stages import merge as stage

    stage.publish(epoch_archive, out)


@app.command(rich_help_panel=STAGE)
def postprocess(
    settings: SettingsText,
    shard: Shard,
    shards: Shards,
    out: Out,
    rejected: Rejected,
    archive: Annotated[Path | None, typer.Option(help="archive of evolved objects")] = None,
    folder: Annotated[Path | None, typer.Option(help="folder of meshes")] = None,
    units: Annotated[str | None, typer.Option(help="unit of these meshes: m, mm, cm, inch")] = None,
    pattern: Annotated[str, typer.Option(help="glob of these meshes in the folder")] = "*",
) -> None:
    """Repair and measure the objects of a shard, from an archive or a folder of meshes."""
    from egad.stage_settings import PostprocessSolids
    from egad.stages import postprocess as stage

    parsed = _parse(PostprocessSolids, settings)
    if archive is not None:
        sources, known = stage.from_archive(archive, parsed, shard, shards)
    elif folder is not None and units is not None:
        sources, known = stage.from_folder(folder, units, shard, shards, pattern)
    else:
        raise UserError("postprocess needs --archive, or --folder and --units")
    stage.run(parsed, sources, known, out, rejected)


@app.command(rich_help_panel=STAGE)
def collect(
    settings: SettingsText,
    source: Annotated[str, typer.Option(help="evolved or meshes")],
    solids: Annotated[list[Path], typer.Option(help="shards of postprocess")],
    rejects: Annotated[list[Path], typer.Option(help="rejected objects of the shards")],
    out: Out,
    rejected: Rejected,
    meshes: OutFolder,
) -> None:
    """Bring the shards of a dataset together: cells, labels, diversities, meshes."""
    from egad.stage_settings import Collect
    from egad.stages import collect as stage

    parsed = _parse(Collect, settings)
    stage.run(parsed, source == "evolved", solids, rejects, out, rejected, meshes)


@app.command(name="grasp-label", rich_help_panel=STAGE)
def grasp_label(
    settings: SettingsText,
    shard: Shard,
    shards: Shards,
    objects: Annotated[Path, typer.Option(help="objects of the dataset")],
    meshes: Annotated[Path, typer.Option(help="folder of the scaled meshes")],
    out: Out,
    rejected: Rejected,
) -> None:
    """Label the grasps of the objects of a shard."""
    from egad.stage_settings import GraspLabels
    from egad.stages import grasp_label as stage

    parsed = _parse(GraspLabels, settings)
    stage.run(parsed, objects, meshes, (shard, shards), out, rejected)


@app.command(rich_help_panel=STAGE)
def join(
    schema: Annotated[str, typer.Option(help="grasps, trials or rejected")],
    parts: list[Path],
    out: Out,
) -> None:
    """Join the tables of all shards into one."""
    from egad.stages import join as stage

    stage.run(schema, parts, out)


@app.command(name="select-eval", rich_help_panel=STAGE)
def select_eval(
    settings: SettingsText,
    objects: Annotated[Path, typer.Option(help="objects of the dataset")],
    solids: Annotated[list[Path], typer.Option(help="shards of postprocess")],
    out: Out,
) -> None:
    """Choose the evaluation set."""
    from egad.stage_settings import EvalSelection
    from egad.stages import select_eval as stage

    stage.run(_parse(EvalSelection, settings), objects, solids, out)


@app.command(name="print-export", rich_help_panel=STAGE)
def print_export(
    settings: SettingsText,
    evaluation: Annotated[Path, typer.Option("--eval", help="evaluation set")],
    meshes: Annotated[Path, typer.Option(help="folder of the scaled meshes")],
    scales: Annotated[Path, typer.Option(help="table of the scales")],
    out: OutFolder,
) -> None:
    """Write STL and 3MF files of the evaluation set, in millimetres."""
    from egad.stage_settings import PrintFiles
    from egad.stages import print_export as stage

    stage.run(_parse(PrintFiles, settings), evaluation, meshes, scales, out)


@app.command(rich_help_panel=STAGE)
def simulate(
    settings: SettingsText,
    policy: Annotated[str, typer.Option(help="grasp detector")],
    shard: Shard,
    shards: Shards,
    evaluation: Annotated[Path, typer.Option("--eval", help="evaluation set")],
    meshes: Annotated[Path, typer.Option(help="folder of the scaled meshes")],
    out: Out,
) -> None:
    """Try to grasp the evaluation objects of a shard in simulation."""
    from egad.stage_settings import SimulatedTrials
    from egad.stages import simulate as stage

    stage.run(_parse(SimulatedTrials, settings), policy, evaluation, meshes, (shard, shards), out)


@app.command(rich_help_panel=STAGE)
def compare(
    settings: SettingsText,
    datasets: Annotated[list[str], typer.Argument(help="NAME=objects.parquet")],
    out: Out,
    figure: Annotated[Path, typer.Option(help="SVG file to write, with a map of each dataset")],
) -> None:
    """Put datasets side by side."""
    from egad.stage_settings import Compare
    from egad.stages import compare as stage

    named = [dataset.partition("=") for dataset in datasets]
    if wrong := [name for name, _, path in named if not path]:
        raise UserError(f"{wrong[0]!r} does not say which table; write NAME=objects.parquet")
    paths = {name: Path(path) for name, _, path in named}
    typer.echo(stage.run(_parse(Compare, settings), paths, out, figure))


@app.command(rich_help_panel=STAGE)
def report(
    settings: SettingsText,
    results: Annotated[Path, typer.Option(help="folder of all results")],
    out: Out,
) -> None:
    """Write the report: one HTML file that opens offline."""
    from egad.stages import report as stage

    stage.run(_parse(Settings, settings), results, out)


@app.command(rich_help_panel=TOOL)
def rescale(
    meshes: Annotated[list[Path], typer.Argument(help="mesh files or folders of them")],
    out: OutFolder,
    settings: Annotated[str | None, typer.Option(help="settings of the stage, as JSON")] = None,
    opening: Annotated[float | None, typer.Option(help="opening of the gripper, metres")] = None,
    rule: Annotated[str, typer.Option(help="paper, egad-script or exact")] = "paper",
    units: Annotated[str, typer.Option(help="unit of the meshes: m, mm, cm, inch")] = "m",
    ending: Annotated[str, typer.Option("--format", help="obj (m) or stl (mm)")] = "obj",
    jobs: Annotated[int, typer.Option(min=1, help="processes")] = 1,
) -> None:
    """Scale any meshes to a gripper."""
    from egad.config_check import check
    from egad.exchange.folders import mesh_files
    from egad.stage_settings import RescaleMeshes, select
    from egad.stages import rescale as stage

    if settings is not None:
        parsed = _parse(RescaleMeshes, settings)
    elif opening is not None:
        grippers = {**Settings().model_dump()["grippers"], "yours": {"opening": opening}}
        config = {"grippers": grippers, "rescale": {"rule": rule}}
        parsed = select(check(config), RescaleMeshes, "yours")
    else:
        raise UserError("rescale needs --opening, the widest opening of the gripper in metres")
    if ending not in stage.WRITERS:
        raise UserError(f"--format is {ending!r}; allowed: {', '.join(stage.WRITERS)}")
    if settings is None:
        files = [
            each for path in meshes for each in ([path] if path.is_file() else mesh_files(path))
        ]
        _spare(out, files)
    else:  # of the pipeline's own folder, which may be empty
        files = [each for path in meshes for each in sorted(path.glob("*.obj"))]
    rejected = stage.run(parsed, files, units, out, ending, jobs)
    if rejected:
        typer.echo(f"{rejected} files could not be used: see {out / 'rejected.parquet'}")


@app.command(rich_help_panel=TOOL)
def materialise(archive: Path, out: OutFolder, config: Config = None) -> None:
    """Write the meshes of an archive as ID.obj, in metres, as they came out of evolution."""
    from egad.stages import materialise as stage

    _spare(out)
    typer.echo(f"{stage.run(archive, out, _settings(config).shape)} meshes in {out}")


@app.command(rich_help_panel=TOOL)
def collage(
    dataset: Annotated[Path, typer.Argument(help="folder of a dataset, e.g. results/egad")],
    out: Out,
    config: Config = None,
) -> None:
    """Draw the objects of a dataset at their places in the space, as one PNG picture."""
    from egad.stages import collage as stage

    stage.run(dataset, out, _settings(config).space)


@app.command(name="check-config", rich_help_panel=TOOL)
def check_config(files: list[Path]) -> None:
    """Check configuration files and list every problem."""
    for file in files:
        _settings(file)
        typer.echo(f"{file}: fine")

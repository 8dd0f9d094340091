"""The commands of the stages: what the rules of the workflow call."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from egad.errors import UserError
from egad.pipeline.cli.common import STAGE, Jobs, Out, OutFolder, app, parse
from egad.pipeline.cli.recorded import recorded, settings_hash
from egad.pipeline.config import Settings

if TYPE_CHECKING:
    from egad.map_elites.parameters import EvolutionParameters
    from egad.report.live_map import LiveMap

SettingsText = Annotated[str, typer.Option("--settings", help="settings of this stage, as JSON")]
Shard = Annotated[int, typer.Option(help="number of this shard")]
Shards = Annotated[int, typer.Option(help="number of all shards")]
Evaluation = Annotated[Path, typer.Option("--eval", help="evaluation set")]
BundleFolder = Annotated[Path, typer.Option("--bundle", help="folder of the simulation bundle")]
Rejected = Annotated[Path, typer.Option(help="table of the objects left out, with reasons")]


@app.command(rich_help_panel=STAGE)
def evolve(
    settings: SettingsText,
    epoch: Annotated[int, typer.Option(help="number of the epoch")],
    island: Annotated[int, typer.Option(help="number of the island")],
    out: Out,
    history: Annotated[Path, typer.Option(help="table of the steps to write")],
    base: Annotated[Path | None, typer.Option(help="archive of the epoch before")] = None,
    page: Annotated[
        Path | None, typer.Option(help="HTML page that shows the map as it fills, to write")
    ] = None,
    islands: Annotated[int | None, typer.Option(help="number of all islands, for the page")] = None,
    jobs: Jobs = 1,
) -> None:
    """Evolve one island for one epoch."""
    from egad.map_elites.parameters import EvolutionParameters
    from egad.pipeline.stages import evolve as stage

    parsed, bases = parse(EvolutionParameters, settings), [base] if base else []
    with recorded("evolve", parsed, bases, epoch=epoch, island=island):
        watch = _live_map(page, parsed, epoch, island, islands) if page else None
        stage.run(parsed, epoch, island, base, out, history, jobs, watch)


def _live_map(
    page: Path, settings: "EvolutionParameters", epoch: int, island: int, islands: int | None
) -> "LiveMap":
    """The page that shows the map while an island evolves."""
    from egad.report.axes import axis_pair
    from egad.report.live_map import EpochOfIsland, LiveMap

    evaluations = settings.evolution.steps_per_epoch * settings.evolution.population
    about = EpochOfIsland(settings_hash(settings), epoch, island, evaluations, islands)
    axes = axis_pair(settings.axes)
    return LiveMap(page, about, settings.space, settings.shape.resolution, axes)


@app.command(rich_help_panel=STAGE)
def merge(settings: SettingsText, islands: list[Path], out: Out, jobs: Jobs = 1) -> None:
    """Merge the islands of an epoch into one archive."""
    from egad.pipeline.config.stage_settings import Merge
    from egad.pipeline.stages import merge as stage

    parsed = parse(Merge, settings)
    with recorded("merge", parsed, islands):
        stage.run(parsed, islands, out, jobs)


@app.command(rich_help_panel=STAGE)
def archive(epoch_archive: Path, out: Out) -> None:
    """Publish the archive of the last epoch."""
    from egad.pipeline.stages import merge as stage

    with recorded("merge", None, [epoch_archive]):
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
    primitives: Annotated[
        int | None, typer.Option(min=1, help="number of objects of primitives joined at random")
    ] = None,
) -> None:
    """Repair and measure the objects of a shard: of an archive, a folder of meshes, or random."""
    from egad.pipeline.config.stage_settings import PostprocessSolids
    from egad.pipeline.stages import postprocess as stage

    parsed = parse(PostprocessSolids, settings)
    if archive is not None:
        sources, known = stage.from_archive(archive, parsed, shard, shards)
        reads = [archive]
    elif folder is not None and units is not None:
        sources, known = stage.from_folder(folder, units, shard, shards, pattern)
        reads = list(stage.files_of_shard(folder, shard, shards, pattern).values())
    elif primitives is not None:
        sources, known = stage.from_primitives(primitives, parsed, shard, shards)
        reads = []
    else:
        raise UserError("postprocess needs --archive, --folder and --units, or --primitives")
    with recorded(
        "postprocess",
        parsed,
        reads,
        shard=shard,
        shards=shards,
        units=units,
        primitives=primitives,
    ):
        stage.run(parsed, sources, known, out, rejected)


@app.command(rich_help_panel=STAGE)
def collect(
    settings: SettingsText,
    source: Annotated[str, typer.Option(help="evolved, archive, meshes or primitives")],
    solids: Annotated[list[Path], typer.Option(help="shards of postprocess")],
    rejects: Annotated[list[Path], typer.Option(help="rejected objects of the shards")],
    out: Out,
    rejected: Rejected,
    meshes: OutFolder,
    jobs: Jobs = 1,
) -> None:
    """Bring the shards of a dataset together: cells, labels, diversities, meshes."""
    from egad.pipeline.config.stage_settings import Collect
    from egad.pipeline.stages import collect as stage

    parsed = parse(Collect, settings)
    with recorded("collect", parsed, [*solids, *rejects], [meshes], source=source):
        evolved = source in ("evolved", "archive")
        stage.run(parsed, evolved, solids, rejects, out, rejected, meshes, jobs)


@app.command(name="grasp-label", rich_help_panel=STAGE)
def grasp_label(
    settings: SettingsText,
    shard: Shard,
    shards: Shards,
    objects: Annotated[Path, typer.Option(help="objects of the dataset")],
    meshes: Annotated[Path, typer.Option(help="folder of the scaled meshes")],
    out: Out,
    tally: Annotated[Path, typer.Option(help="table of what became of candidates, to write")],
    rejected: Rejected,
) -> None:
    """Label the grasps of the objects of a shard."""
    from egad.grasps.parameters import LabelParameters
    from egad.pipeline.stages import grasp_label as stage

    parsed = parse(LabelParameters, settings)
    with recorded("grasp_label", parsed, [objects, meshes], shard=shard, shards=shards):
        stage.run(parsed, objects, meshes, (shard, shards), out, tally, rejected)


@app.command(rich_help_panel=STAGE)
def join(
    parts: list[Path],
    by: Annotated[list[str], typer.Option(help="column to sort by; may be repeated")],
    out: Out,
) -> None:
    """Join the tables of all shards into one."""
    from egad.pipeline.stages import join as stage

    with recorded("join", None, parts, by=by):
        stage.run(parts, by, out)


@app.command(name="select-eval", rich_help_panel=STAGE)
def select_eval(
    settings: SettingsText,
    objects: Annotated[Path, typer.Option(help="objects of the dataset")],
    solids: Annotated[list[Path], typer.Option(help="shards of postprocess")],
    out: Out,
    rejected: Rejected,
    jobs: Jobs = 1,
) -> None:
    """Choose the evaluation set."""
    from egad.pipeline.config.stage_settings import EvalSelection
    from egad.pipeline.stages import select_eval as stage

    parsed = parse(EvalSelection, settings)
    with recorded("select_eval", parsed, [objects, *solids]):
        stage.run(parsed, objects, solids, out, rejected, jobs)


@app.command(name="size-effect-eval", rich_help_panel=STAGE)
def size_effect_eval(
    settings: SettingsText,
    evaluation: Evaluation,
    meshes: Annotated[Path, typer.Option(help="folder of the meshes of the dataset")],
    out: Out,
) -> None:
    """Rate an easy, a middling and a hard object of the evaluation set at several sizes."""
    from egad.measures.parameters import SizeEffectParameters
    from egad.pipeline.stages import size_effect as stage

    parsed = parse(SizeEffectParameters, settings)
    with recorded("size_effect", parsed, [evaluation, meshes]):
        stage.run(parsed, evaluation, meshes, out)


@app.command(name="print-export", rich_help_panel=STAGE)
def print_export(
    settings: SettingsText,
    evaluation: Evaluation,
    meshes: Annotated[Path, typer.Option(help="folder of the scaled meshes")],
    scales: Annotated[Path, typer.Option(help="table of the scales")],
    gripper: Annotated[str, typer.Option(help="name of the gripper, for the plates")],
    out: OutFolder,
    grasps: Annotated[Path | None, typer.Option(help="labelled grasps, for an engraving")] = None,
) -> None:
    """Write STL and 3MF files of the evaluation set, in millimetres."""
    from egad.pipeline.config.stage_settings import PrintFiles
    from egad.pipeline.stages import print_export as stage

    parsed = parse(PrintFiles, settings)
    reads = [evaluation, meshes, *([grasps] if grasps else [])]
    with recorded("print_export", parsed, reads, [out], gripper=gripper):
        stage.run(parsed, gripper, evaluation, meshes, scales, out, grasps)


@app.command(rich_help_panel=STAGE)
def datasheet(
    settings: SettingsText,
    dataset: Annotated[str, typer.Option(help="name of the dataset")],
    evaluation: Evaluation,
    manifest: Annotated[list[str], typer.Option(help="GRIPPER=manifest.parquet")],
    grasps: Annotated[list[str], typer.Option(help="GRIPPER=grasps.parquet")],
    out: OutFolder,
) -> None:
    """Write what there is to know about an evaluation set, for people."""
    from egad.pipeline.config.stage_settings import DataSheets
    from egad.pipeline.stages import datasheet as stage

    manifests, labelled = _by_name(manifest, "manifest"), _by_name(grasps, "grasps")
    parsed = parse(DataSheets, settings)
    reads = [evaluation, *manifests.values(), *labelled.values()]
    with recorded("datasheet", parsed, reads, [out], dataset=dataset, grippers=list(manifests)):
        stage.run(parsed, dataset, evaluation, manifests, labelled, out)


@app.command(name="dexnet-objects", rich_help_panel=STAGE)
def dexnet_objects(
    settings: SettingsText,
    shard: Shard,
    shards: Shards,
    objects: Annotated[Path, typer.Option(help="objects of the dataset")],
    meshes: Annotated[Path, typer.Option(help="folder of the scaled meshes")],
    out: Out,
) -> None:
    """Write the objects of a shard for a Dex-Net database: distance fields, stable poses."""
    from egad.pipeline.config.stage_settings import DexNetObjects
    from egad.pipeline.stages import dexnet_objects as stage

    parsed = parse(DexNetObjects, settings)
    with recorded("dexnet_objects", parsed, [objects, meshes], [out], shard=shard, shards=shards):
        stage.run(parsed, objects, meshes, (shard, shards), out)


@app.command(rich_help_panel=STAGE)
def simulate(
    settings: SettingsText,
    shard: Shard,
    shards: Shards,
    evaluation: Evaluation,
    bundle: BundleFolder,
    out: Out,
    grasps: Annotated[Path | None, typer.Option(help="labelled grasps, for `labels`")] = None,
) -> None:
    """Try to grasp the evaluation objects of a shard in simulation."""
    from egad.pipeline.stages import simulate as stage
    from egad.sim.parameters import TrialParameters

    parsed = parse(TrialParameters, settings)
    reads = [evaluation, bundle, *([grasps] if grasps else [])]
    with recorded("simulate", parsed, reads, shard=shard, shards=shards):
        stage.run(parsed, evaluation, bundle, grasps, (shard, shards), out)


@app.command(rich_help_panel=STAGE)
def agreement(
    settings: SettingsText,
    shard: Shard,
    shards: Shards,
    evaluation: Evaluation,
    bundle: BundleFolder,
    grasps: Annotated[Path, typer.Option(help="labelled grasps")],
    out: Out,
) -> None:
    """Carry out labelled grasps of the evaluation objects of a shard in simulation."""
    from egad.pipeline.stages import agreement as stage
    from egad.sim.parameters import LabelTrialParameters

    parsed = parse(LabelTrialParameters, settings)
    reads = [evaluation, bundle, grasps]
    with recorded("agreement", parsed, reads, shard=shard, shards=shards):
        stage.run(parsed, evaluation, bundle, grasps, (shard, shards), out)


@app.command(rich_help_panel=STAGE)
def compare(
    settings: SettingsText,
    datasets: Annotated[list[str], typer.Argument(help="NAME=objects.parquet")],
    out: Out,
    figure: Annotated[Path, typer.Option(help="SVG file to write, with a map of each dataset")],
) -> None:
    """Put datasets side by side."""
    from egad.pipeline.config.stage_settings import Compare
    from egad.pipeline.stages import compare as stage

    paths = _by_name(datasets, "objects")
    parsed = parse(Compare, settings)
    with recorded("compare", parsed, paths.values(), [figure], datasets=list(paths)):
        typer.echo(stage.run(parsed, paths, out, figure))


@app.command(rich_help_panel=STAGE)
def report(
    settings: SettingsText,
    results: Annotated[Path, typer.Option(help="folder of all results")],
    out: Out,
    reads: Annotated[
        list[Path] | None, typer.Argument(help="what it shows, for the record")
    ] = None,
    jobs: Jobs = 1,
) -> None:
    """Write the report: one HTML file that opens offline."""
    from egad.pipeline.stages import report as stage

    parsed = parse(Settings, settings)
    with recorded("report", parsed, reads or [], [out]):
        stage.run(parsed, results, out, jobs)


def _by_name(words: list[str], table: str) -> dict[str, Path]:
    """Files by the names before their equals signs."""
    named = [word.partition("=") for word in words]
    if wrong := [name for name, _, path in named if not path]:
        raise UserError(f"{wrong[0]!r} does not say which table; write NAME={table}.parquet")
    return {name: Path(path) for name, _, path in named}

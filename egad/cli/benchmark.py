"""The standard benchmark: a detector clears tables."""

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from egad.cli.common import (
    CORES,
    Command,
    Config,
    DetectorName,
    Jobs,
    Rule,
    Units,
    Weights,
    detector_in,
    files_in,
    gripper_in,
    gripper_option,
    out_option,
    settings_in,
    with_option,
)
from egad.errors import UserError

FOLDER = Path("benchmark")

if TYPE_CHECKING:
    from egad.benchmark import Benchmark
    from egad.config.stages import ClearedTables
    from egad.named_meshes import NamedMesh


def benchmark(
    detector: DetectorName,
    weights: Weights = None,
    command: Command = None,
    objects: Annotated[
        str,
        typer.Option(help="evaluation-set, the folder of a dataset, or a folder of mesh files"),
    ] = "evaluation-set",
    units: Units = None,
    gripper: Annotated[str, gripper_option()] = "panda",
    protocol: Annotated[
        str | None,
        typer.Option(
            help="rules of a published benchmark: egad, vgn, giga or edgegrasp; default: "
            "clutter.protocol"
        ),
    ] = None,
    rounds: Annotated[
        int | None,
        typer.Option(min=1, help="rounds of each kind of scene and noise; default: clutter.rounds"),
    ] = None,
    keep_going: Annotated[
        bool,
        typer.Option("--keep-going", help="continue even if the detector fails in every attempt"),
    ] = False,
    rule: Rule = None,
    films: Annotated[
        Path | None,
        typer.Option(help="folder for films of the first round of each kind of scene"),
    ] = None,
    out: Annotated[
        Path | None, out_option("table to write; default: benchmark/DETECTOR.parquet")
    ] = None,
    config: Config = None,
    jobs: Jobs = CORES,
) -> None:
    """Let a grasp detector clear tables: success rates and shares of objects cleared."""
    from egad.cli.terminal_tables import cleared
    from egad.config.stages import ClearedTables, select
    from egad.io import check_ending
    from egad.provenance.record import recorded
    from egad.sim import check_engine
    from egad.stats import engine_names

    settings = with_option(settings_in(config), "--protocol", "clutter.protocol", protocol)
    settings = with_option(settings, "--rounds", "clutter.rounds", rounds)
    settings = with_option(settings, "--keep-going", "clutter.keep_going", keep_going or None)
    settings = with_option(settings, "--rule", "rescale.rule", rule)
    settings, gripper = gripper_in(settings, gripper)
    check_engine(settings.clutter.engine)
    settings, name = detector_in(settings, detector, weights, command)
    path = out or FOLDER / f"{name}.parquet"
    for folder in [films, None if out else FOLDER]:
        if folder is not None:
            folder.mkdir(exist_ok=True)
    check_ending(path, (".parquet",))
    targets, files = _objects(objects, units)
    chosen = select(settings, ClearedTables, gripper, name)
    arguments = {"objects": Path(objects).name, "rule": settings.rescale.rule}
    with recorded("benchmark", settings=chosen, inputs=files, arguments=arguments):
        result = _clear_and_write(chosen, settings.rescale.rule, targets, path, jobs)
    cleared({name: result.rates()}, {name: engine_names(result.table)})
    typer.echo(f"protocol: {settings.clutter.protocol.name}")
    outcomes = result.table["outcome"].value_counts()
    typer.echo(f"outcomes: {', '.join(f'{count} {name}' for name, count in outcomes.items())}")
    typer.echo(f"planning takes {result.planning_time:.2g} s (median); attempts: {path}")
    if films is not None:
        for kind in settings.clutter.scenes:
            result.film(kind, 0, films / f"{name}-{kind}.gif", settings.clutter.noises[0])


def _clear_and_write(
    settings: "ClearedTables", rule: str, targets: "Sequence[NamedMesh]", out: Path, jobs: int
) -> "Benchmark":
    """Let a detector clear tables of objects, and write a table of its attempts."""
    from egad.benchmark import clear_tables
    from egad.clearing import check_detector, prepare_objects
    from egad.detectors import keep_failure
    from egad.tables import parquet
    from egad.tables.clutter import CLUTTER

    label_seed = settings.seed if settings.detector.detector == "labels" else None
    check_detector(settings.detector, settings)
    known = prepare_objects(targets, settings.gripper, rule, label_seed, jobs)
    with keep_failure(out):
        found = clear_tables(settings.detector, known, settings, jobs)
    parquet.write(found.table, CLUTTER, out)
    return found


def _objects(text: str, units: str | None) -> tuple[list["NamedMesh"], list[Path]]:
    """The objects named on a command line, and the files that they come from."""
    from egad.io import object_names, read_mesh
    from egad.named_meshes import NamedMesh, named_meshes
    from egad.objects import EVALUATION_SET, load
    from egad.tables import parquet
    from egad.tables.evaluation import EVAL49

    folder = Path(text)
    if text == EVALUATION_SET:
        return named_meshes(load(text)), []
    if not folder.is_dir():
        raise UserError(f"--objects {text} is neither {EVALUATION_SET} nor a folder")
    table, chosen = folder / "objects.parquet", folder / "eval49.parquet"
    if chosen.is_file():
        ids = parquet.read(chosen, EVAL49)["id"]
        return named_meshes(load(folder).select(ids)), [table, chosen]
    if table.is_file():
        return named_meshes(load(folder)), [table]
    files = object_names(files_in([folder], units))
    return [
        NamedMesh(name, name, partial(read_mesh, path, units)) for name, path in files.items()
    ], list(files.values())

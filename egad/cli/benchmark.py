"""The standard benchmark: a detector clears tables."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from egad.cli.common import (
    CORES,
    Command,
    Config,
    DetectorName,
    Jobs,
    KeepGoing,
    Objects,
    Rule,
    Units,
    Weights,
    detector_in,
    gripper_in,
    gripper_option,
    out_option,
    settings_in,
)
from egad.cli.repeat import run_trials

FOLDER = Path("benchmark")

if TYPE_CHECKING:
    from egad.bench import ClearedTables
    from egad.bench.benchmark import Benchmark
    from egad.objects import NamedMesh


def benchmark(
    detector: DetectorName,
    weights: Weights = None,
    command: Command = None,
    objects: Objects = "evaluation-set",
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
    keep_going: KeepGoing = False,
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
    from egad.bench import ClearedTables
    from egad.bench.stats import engine_names
    from egad.cli.terminal_tables import cleared, outcome_list
    from egad.io import check_ending
    from egad.sim import check_engine
    from egad.tables.clutter import CLUTTER
    from egad_workflow.settings import select

    options = {
        "--protocol": ("clutter.protocol", protocol),
        "--rounds": ("clutter.rounds", rounds),
        "--keep-going": ("clutter.keep_going", keep_going or None),
        "--rule": ("rescale.rule", rule),
    }
    settings = settings_in(config, options)
    settings, gripper = gripper_in(settings, gripper)
    check_engine(settings.clutter.engine)
    settings, name = detector_in(settings, detector, weights, command)
    path, scaling = out or FOLDER / f"{name}.parquet", settings.rescale.rule
    check_ending(out, (".parquet",))
    chosen = select(settings, ClearedTables, gripper, name)
    if films is not None:
        films.mkdir(exist_ok=True)
    result = run_trials(
        "benchmark",
        lambda targets: _clear(chosen, scaling, targets, jobs),
        *(chosen, scaling, gripper, (objects, units), (path, CLUTTER)),
    )
    cleared({name: result.rates()}, {name: engine_names(result.table)})
    typer.echo(f"protocol: {settings.clutter.protocol.name}")
    typer.echo(f"outcomes: {outcome_list(result.table)}")
    typer.echo(f"planning takes {result.planning_time:.2g} s (median); attempts: {path}")
    if films is not None:
        for kind in settings.clutter.scenes:
            result.film(kind, 0, films / f"{name}-{kind}.gif", settings.clutter.noises[0])


def _clear(
    settings: "ClearedTables", rule: str, targets: "Sequence[NamedMesh]", jobs: int
) -> "Benchmark":
    """Let a detector clear tables of objects."""
    from egad.bench.benchmark import clear_tables
    from egad.bench.clearing import check_detector, prepare_objects

    label_seed = settings.seed if settings.detector.detector == "labels" else None
    check_detector(settings.detector, settings)
    known = prepare_objects(targets, settings.gripper, rule, label_seed, jobs)
    return clear_tables(settings.detector, known, settings, jobs)

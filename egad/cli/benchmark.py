"""The standard benchmark: a detector clears tables."""

from pathlib import Path
from typing import Annotated

import typer

from egad.cli import common
from egad.cli.repeat import run_trials

FOLDER = Path("benchmark")


def benchmark(
    detector: common.DetectorName,
    weights: common.Weights = None,
    command: common.Command = None,
    objects: common.Objects = "evaluation-set",
    units: common.Units = None,
    gripper: Annotated[str, common.gripper_option()] = "panda",
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
    keep_going: common.KeepGoing = False,
    rule: common.Rule = None,
    films: Annotated[
        Path | None, typer.Option(help="folder for films of the first round of each kind of scene")
    ] = None,
    out: Annotated[
        Path | None, common.out_option("table to write; default: benchmark/DETECTOR.parquet")
    ] = None,
    config: common.Config = None,
    jobs: common.Jobs = common.CORES,
) -> None:
    """Let a grasp detector clear tables: success rates and shares of objects cleared."""
    from egad.bench import ClearedTables
    from egad.bench.benchmark import try_tables
    from egad.bench.stats import engine_names
    from egad.cli.terminal_tables import cleared, outcome_list
    from egad.io import check_ending
    from egad.sim import check_engine
    from egad.tables.clutter import CLUTTER
    from egad_workflow.settings import select

    options = {
        "--protocol": ("clutter.protocol", protocol),
        "--rounds": ("clutter.rounds", rounds),
        "--keep-going": ("keep_going", keep_going or None),
        "--rule": ("rescale.rule", rule),
    }
    settings, gripper, name = common.settings_to_try(
        config, options, gripper, detector, weights, command
    )
    check_engine(settings.clutter.engine)
    path, scaling = out or FOLDER / f"{name}.parquet", settings.rescale.rule
    check_ending(out, (".parquet",))
    chosen = select(settings, ClearedTables, gripper, name)
    if films is not None:
        films.mkdir(exist_ok=True)
    result = run_trials(
        "benchmark",
        lambda targets, grasps: try_tables(
            chosen.detector, targets, chosen, scaling, jobs, settings.keep_going, grasps
        ),
        *(chosen, scaling, gripper, (objects, units), (path, CLUTTER)),
    )
    cleared({name: result.rates()}, {name: engine_names(result.table)})
    typer.echo(f"protocol: {settings.clutter.protocol.name}")
    typer.echo(f"outcomes: {outcome_list(result.table)}")
    typer.echo(f"planning takes {result.planning_time:.2g} s (median); attempts: {path}")
    if films is not None:
        for kind in settings.clutter.scenes:
            result.film(kind, 0, films / f"{name}-{kind}.gif", settings.clutter.noises[0])

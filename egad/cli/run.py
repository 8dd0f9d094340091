"""Simulated trials of a detector."""

from pathlib import Path
from typing import Annotated

import typer

from egad.cli import common
from egad.cli.repeat import run_trials

FOLDER = Path("trials")


def run(
    detector: common.DetectorName,
    weights: common.Weights = None,
    command: common.Command = None,
    objects: common.Objects = "evaluation-set",
    units: common.Units = None,
    gripper: Annotated[str, common.gripper_option()] = "egad_75mm",
    attempts: Annotated[
        int | None, typer.Option(min=1, help="attempts at each object; default: trials.attempts")
    ] = None,
    seed: Annotated[
        int | None,
        typer.Option(min=0, help="seed of everything random; default: that of the configuration"),
    ] = None,
    keep_going: common.KeepGoing = False,
    rule: common.Rule = None,
    out: Annotated[
        Path | None, common.out_option(f"table to write; default: {FOLDER}/DETECTOR.parquet")
    ] = None,
    config: common.Config = None,
    jobs: common.Jobs = common.CORES,
) -> None:
    """Let a grasp detector grasp objects in simulation, one at a time, as `egad.run_trials` does.

    Other settings, such as the engine, depth noise and errors of a real cell, are in the section
    `trials` of --config.
    """
    from egad.bench import SimulatedTrials
    from egad.bench.stats import simulated_in
    from egad.bench.trials import try_objects
    from egad.cli.terminal_tables import outcome_list, succeeded
    from egad.io import check_ending
    from egad.sim import check_engine
    from egad.tables.evaluation import TRIALS
    from egad_workflow.settings import select

    options = {
        "--attempts": ("trials.attempts", attempts),
        "--seed": ("seed", seed),
        "--keep-going": ("keep_going", keep_going or None),
        "--rule": ("rescale.rule", rule),
    }
    settings, gripper, name = common.settings_to_try(
        config, options, gripper, detector, weights, command
    )
    check_engine(settings.trials.engine)
    path, scaling = out or FOLDER / f"{name}.parquet", settings.rescale.rule
    check_ending(out, (".parquet",))
    chosen = select(settings, SimulatedTrials, gripper, name)
    result = run_trials(
        "trials run",
        lambda targets, grasps: try_objects(
            chosen.detector, targets, chosen, scaling, jobs, settings.keep_going, grasps
        ),
        *(chosen, scaling, gripper, (objects, units), (path, TRIALS)),
    )
    succeeded({path.stem: result.success_rate()}, {path.stem: simulated_in(result.table)})
    typer.echo(f"outcomes: {outcome_list(result.table)}")
    typer.echo(f"attempts: {path}")

"""Whether a table of simulated attempts can be reproduced."""

from pathlib import Path
from typing import Annotated

import typer

from egad.cli.common import CORES, Config, Jobs
from egad.cli.repeat import RunGripper, SimulatedIn, repeatable
from egad.errors import UserError

SHOWN = 10  # differences


def verify_trials(
    table: Annotated[Path, typer.Argument(help="simulated attempts, or cleared tables: .parquet")],
    dataset: SimulatedIn = None,
    gripper: RunGripper = None,
    sample: Annotated[
        int | None,
        typer.Option(min=1, help="number of objects, or rounds, to verify; default: all"),
    ] = None,
    tolerance: Annotated[
        float,
        typer.Option(min=0, help="how much numbers may differ, for another kind of processor"),
    ] = 0.0,
    config: Config = None,
    jobs: Jobs = CORES,
) -> None:
    """Simulate the attempts of a table again, without their detector, and say which differ."""
    import pandas as pd

    from egad.bench import ClutterParameters, TrialParameters, gaps, groups_of, verify_groups
    from egad.tables import parquet
    from egad.tables.clutter import CLUTTER
    from egad.tables.evaluation import TRIALS
    from egad_workflow.settings import select

    settings, hand, models = repeatable(table, dataset, gripper, config)
    is_clutter = "scene" in parquet.columns(table)
    rows = parquet.read(table, CLUTTER if is_clutter else TRIALS)
    groups = groups_of(rows, sample, settings.seed)
    attempts = sum(map(len, groups))
    if not attempts:
        raise UserError(f"{table}: no attempt to verify")
    parameters: TrialParameters | ClutterParameters = (
        select(settings, ClutterParameters, hand)
        if is_clutter
        else select(settings, TrialParameters, hand)
    )
    differences = verify_groups(groups, models, parameters, tolerance, jobs)
    for each in differences[:SHOWN]:
        typer.echo(f"{each.place}: {each.column} is {each.said}, simulated: {each.found}")
    if len(differences) > SHOWN:
        typer.echo(f"and {len(differences) - SHOWN} more")
    if differences:
        raise UserError(
            f"{table}: {len({each.place for each in differences})} of {attempts} attempts are not "
            "reproduced: the table was altered, or settings, objects, the version of the engine or "
            "the kind of processor differ from those of the trials"
        )
    typer.echo(f"{table}: {attempts} of {len(rows)} attempts simulated again: all as in the table")
    labels = dict(zip(rows["id"], rows.get("label", rows["id"]), strict=True))
    objects = [(labels.get(name, name), name) for name in models]
    missing = list(gaps(rows, pd.DataFrame(objects, columns=["label", "id"]), parameters))
    if missing:
        more = f", and {len(missing) - 1} more" if len(missing) > 1 else ""
        typer.echo(f"The table does not match the configuration: {missing[0]}{more}", err=True)

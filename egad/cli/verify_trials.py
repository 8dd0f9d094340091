"""Whether a table of simulated attempts can be reproduced."""

from pathlib import Path
from typing import Annotated

import typer

from egad.cli.common import CORES, Config, Jobs
from egad.cli.repeat import RunGripper, SimulatedIn, repeatable
from egad.errors import UserError


def verify_trials(
    table: Annotated[Path, typer.Argument(help="simulated attempts, or cleared tables: .parquet")],
    dataset: SimulatedIn = None,
    gripper: RunGripper = None,
    sample: Annotated[
        int | None,
        typer.Option(min=1, help="number of objects, or rounds, to verify; default: all"),
    ] = None,
    config: Config = None,
    jobs: Jobs = CORES,
) -> None:
    """Simulate the attempts of a table again, without their detector, and say what differs.

    Other processors may round otherwise: attempts that differ for that reason do not count.
    """
    import pandas as pd

    from egad.bench import (
        ClutterParameters,
        TrialParameters,
        gaps,
        groups_of,
        refusal,
        verify_groups,
    )
    from egad.tables import parquet
    from egad.tables.clutter import CLUTTER
    from egad.tables.evaluation import TRIALS
    from egad_workflow.settings import select

    settings, hand, models = repeatable(table, dataset, gripper, config)
    is_clutter = "scene" in parquet.columns(table)
    rows = parquet.read(table, CLUTTER if is_clutter else TRIALS)
    groups = groups_of(rows, sample, settings.seed)
    if not groups:
        raise UserError(f"{table}: no attempt to verify")
    parameters: TrialParameters | ClutterParameters = (
        select(settings, ClutterParameters, hand)
        if is_clutter
        else select(settings, TrialParameters, hand)
    )
    reproduction = verify_groups(groups, models, parameters, jobs)
    if reasons := refusal(reproduction, rows):
        raise UserError("\n".join([f"{table}: {reasons[0]}", *reasons[1:]]))
    typer.echo(f"{table}: {reproduction}")
    labels = dict(zip(rows["id"], rows.get("label", rows["id"]), strict=True))
    objects = [(labels.get(name, name), name) for name in models]
    missing = list(gaps(rows, pd.DataFrame(objects, columns=["label", "id"]), parameters))
    if missing:
        more = f", and {len(missing) - 1} more" if len(missing) > 1 else ""
        typer.echo(f"The table does not match the configuration: {missing[0]}{more}", err=True)

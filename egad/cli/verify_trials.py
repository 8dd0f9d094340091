"""Whether a table of simulated attempts can be reproduced."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from egad.cli.common import RUN, Config, DatasetIn, named_gripper, settings_in
from egad.cli.replay import RunGripper
from egad.errors import UserError

if TYPE_CHECKING:
    import pandas as pd

    from egad.config import Settings
    from egad.sim import Difference

SHOWN = 10  # differences


def verify_trials(
    table: Annotated[Path, typer.Argument(help="simulated attempts, or cleared tables: .parquet")],
    dataset: DatasetIn = RUN,
    gripper: RunGripper = None,
    sample: Annotated[
        int | None, typer.Option(min=1, help="objects, or rounds, to look at; default: all")
    ] = None,
    tolerance: Annotated[
        float,
        typer.Option(min=0, help="by how much numbers may differ, on another kind of processor"),
    ] = 0.0,
    config: Config = None,
) -> None:
    """Simulate the attempts of a table again, without their detector, and say which differ."""
    from egad.tables import parquet
    from egad.tables.clutter import CLUTTER
    from egad.tables.evaluation import TRIALS

    settings = settings_in(config)
    hand = named_gripper(settings, gripper)
    is_clutter = "scene" in parquet.columns(table)
    rows = parquet.read(table, CLUTTER if is_clutter else TRIALS)
    keys = ["scene", "noise", "round"] if is_clutter else ["id"]
    chosen = _sampled(rows, keys, sample, settings.seed)
    bundle = dataset / "bundle" / hand
    if not len(chosen):
        raise UserError(f"{table}: no attempt to look at")
    check = _rounds if is_clutter else _attempts
    found = list(check(chosen, bundle, settings, hand, tolerance))
    for each in found[:SHOWN]:
        typer.echo(f"{each.place}: {each.column} is {each.said}, simulated: {each.found}")
    if len(found) > SHOWN:
        typer.echo(f"and {len(found) - SHOWN} more")
    if found:
        raise UserError(
            f"{table}: {len({each.place for each in found})} of {len(chosen)} attempts are not "
            "reproduced: the table was altered, or settings, objects, the version of the engine or "
            "the kind of processor differ from those of the trials"
        )
    typer.echo(f"{table}: {len(chosen)} of {len(rows)} attempts simulated again: all as it says")


def _sampled(rows: "pd.DataFrame", keys: list[str], count: int | None, seed: int) -> "pd.DataFrame":
    """All rows of some objects or rounds, drawn with the seed."""
    from egad.random import generator

    number = rows.groupby(keys, sort=False).ngroup()
    groups = number.max() + 1 if len(rows) else 0
    if count is None or count >= groups:
        return rows
    return rows[number.isin(generator(seed, "verify").choice(groups, count, replace=False))]


def _attempts(
    rows: "pd.DataFrame", bundle: Path, settings: "Settings", hand: str, tolerance: float
) -> "Iterator[Difference]":
    from egad._util.progress import progress
    from egad.config.stages import select
    from egad.outcomes import SIMULATION_FAILURES
    from egad.sim import TrialParameters, verify_attempts
    from egad.workflow.bundled import model_in, rows_by_id

    known, parameters = rows_by_id(bundle), select(settings, TrialParameters, hand)
    groups = list(rows.groupby("id", sort=False))
    for key, attempts in progress(groups, "simulating", len(groups)):
        name = str(key)
        if attempts["outcome"].isin(SIMULATION_FAILURES).all():
            continue
        if name in known:
            yield from verify_attempts(
                model_in(bundle, known[name]), attempts, parameters, tolerance
            )
        else:
            raise UserError(f"{bundle}: no object {attempts['label'].iloc[0]} ({name})")


def _rounds(
    rows: "pd.DataFrame", bundle: Path, settings: "Settings", hand: str, tolerance: float
) -> "Iterator[Difference]":
    from egad.config.stages import select
    from egad.sim import ClutterParameters, verify_rounds
    from egad.workflow.bundled import model_in, rows_by_id

    models = {name: model_in(bundle, row) for name, row in rows_by_id(bundle).items()}
    yield from verify_rounds(rows, models, select(settings, ClutterParameters, hand), tolerance)

"""Simulated results against those of a robot."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from egad.errors import UserError

if TYPE_CHECKING:
    import pandas as pd


def validate(
    tables: Annotated[
        list[Path],
        typer.Argument(
            help="simulated results, .parquet or .csv, or success rates of objects, .csv; "
            "the last file has the real results, unless --real is given"
        ),
    ],
    real: Annotated[
        list[Path] | None, typer.Option("--real", help="real results; may be repeated")
    ] = None,
) -> None:
    """Compare simulated success rates with real ones, object by object and detector by detector.

    Detectors are matched by name, objects by label. A CSV file has a row for each attempt (label,
    attempt, success), or for each object (label and success_rate, or label, successes and
    attempts); both may have a column detector. Predicts the real success rate where more objects
    were simulated than tried.
    """
    from egad.bench.stats import validate as compare_sides
    from egad.cli.terminal_tables import agreements, predicted

    simulated = tables if real else tables[:-1]
    if not simulated:
        raise UserError("validate needs simulated and real results: at least two files")
    found = compare_sides(_gather(simulated), _gather(real or tables[-1:]))
    agreements(found.objects, "objects")
    if found.detectors is not None:
        typer.echo()
        agreements({"all": found.detectors}, "detectors")
    if found.predicted:
        typer.echo()
        predicted(found.predicted)
    for note in found.notes:
        typer.echo(note, err=True)


def _gather(paths: list[Path]) -> "dict[str, pd.DataFrame]":
    """Success rates of the objects in several files, by detector."""
    from egad.bench.stats import read_rates

    found: dict[str, pd.DataFrame] = {}
    for path in paths:
        for name, table in read_rates(path).items():
            if name in found:
                raise UserError(f"{path}: two tables have the same detector {name}; rename one")
            found[name] = table
    return found

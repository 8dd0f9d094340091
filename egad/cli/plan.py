"""How many attempts a comparison of two detectors needs."""

from pathlib import Path
from typing import Annotated

import typer


def plan(
    tables: Annotated[
        list[Path] | None,
        typer.Option(
            "--from",
            help="results with objects that vary like yours: .parquet or .csv; may be repeated",
        ),
    ] = None,
    difference: Annotated[
        float, typer.Option(help="difference between the detectors, percentage points")
    ] = 10,
    objects: Annotated[
        list[int], typer.Option(min=1, max=1000, help="objects to try; may be repeated")
    ] = [10, 20, 49, 100],  # noqa: B006 (typer copies it)
    most: Annotated[
        int, typer.Option(min=1, max=1000, help="maximum number of attempts at each object")
    ] = 100,
    rate: Annotated[
        float | None, typer.Option(help="mean success rate, %; default: that of --from, else 60")
    ] = None,
    spread: Annotated[
        float | None,
        typer.Option(
            help="standard deviation of the rates of objects, percentage points; default: "
            "that of --from, else 30"
        ),
    ] = None,
    correlation: Annotated[
        float | None,
        typer.Option(
            help="correlation of both detectors over objects; default: that of the tables if "
            "--from names several detectors, else 0.7"
        ),
    ] = None,
    power: Annotated[float, typer.Option(help="probability of finding the better one")] = 0.8,
    level: Annotated[
        float, typer.Option(help="probability of finding a better one if both are equal")
    ] = (0.05),
    seed: Annotated[int, typer.Option(min=0, help="seed of the simulation")] = 0,
) -> None:
    """Find how many attempts show a difference between two detectors, by simulation over objects.

    The numbers are for the test over objects of `egad trials compare`, and for its `--sequential`
    test, with the objects tried in rounds. Both detectors make the same number of attempts. A dash
    means: not even with --most attempts at each object.
    """
    from dataclasses import replace

    from egad._util.progress import progress
    from egad.bench.stats import ObjectRates, fit_object_rates, gather, plan_attempts
    from egad.cli.terminal_tables import planned

    rates = fit_object_rates(list(gather(tables).values())) if tables else ObjectRates()
    given = {
        "mean": None if rate is None else rate / 100,
        "spread": None if spread is None else spread / 100,
        "correlation": correlation,
    }
    rates = replace(rates, **{name: value for name, value in given.items() if value is not None})
    typer.echo(
        f"Success {100 * rates.mean:.0f} %, objects vary by {100 * rates.spread:.0f} points "
        f"(standard deviation), correlation of both detectors {rates.correlation:.2f}; "
        f"difference {difference:g} points, power {power:g}, level {level:g}"
    )
    plans = [
        plan_attempts(
            count,
            rates,
            difference=difference / 100,
            power=power,
            level=level,
            most=most,
            seed=seed,
        )
        for count in progress(objects, "simulating", len(objects))
    ]
    planned(plans, power)

"""Tables on the terminal."""

import sys
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

import pandas as pd
from rich.console import Console
from rich.table import Table

from egad.bench.stats import (
    Agreement,
    Clearing,
    ClearingComparison,
    Comparison,
    Estimate,
    Mean,
    Plan,
    PredictedRate,
    SequentialTest,
)
from egad.measures import cell_name
from egad.report.axes import AxisPair
from egad.report.page import p_value

if TYPE_CHECKING:
    from egad.report.trials import Pair  # it loads Matplotlib

DASH = "-"
WIDE = 200  # columns of a table that goes into a file
MAX_COLUMNS = 12  # columns of a matrix that still can be read


def measured(table: pd.DataFrame, axes: AxisPair) -> None:
    """Print name, measures and cell of meshes: columns of `tables.objects.MEASURED`."""
    show(["name", *_titles(axes), "cell"], [_place(row, axes) for row in _rows(table)])


def located(table: pd.DataFrame, axes: AxisPair) -> None:
    """Print columns of `tables.objects.LOCATED`."""
    orders = (f"{axis.before} %" for axis in (axes.across, axes.upwards))
    show(
        ["name", *_titles(axes), "cell", *orders, "diversity", "nearest"],
        [
            (
                *_place(row, axes),
                number(row["complexity_percentile"], 0),
                number(row["difficulty_percentile"], 0),
                number(row["diversity"], 3),
                row["nearest"][0] if isinstance(row["nearest"], list) else DASH,
            )
            for row in _rows(table)
        ],
    )


def size_curves(table: pd.DataFrame) -> None:
    """Print columns of `tables.grasping.SIZE_EFFECT`: means, lowest to highest in brackets."""
    from egad.measures import summarize

    numbers = summarize(table)
    percents = [f"{percent:g}" for percent in numbers["percentile"].unique()]
    show(
        ["name", "side/opening", "possible %", *(f"quality p{each}, 1e-3" for each in percents)],
        [
            (
                str(name),
                number(float(rows["fraction"].iloc[0]), 2),
                number(100 * rows["share"].iloc[0], 1),
                *(_spread(row) for row in _rows(rows)),
            )
            for (name, _), rows in numbers.groupby(["name", "fraction"], sort=False)
        ],
    )


def square(matrix: pd.DataFrame) -> None:
    """Print a matrix of similarities, or a summary if it is too large."""
    if len(matrix) > MAX_COLUMNS:
        known = matrix.notna().any()
        print(f"{len(matrix)} meshes, {known.sum()} compared; --out writes their similarities")
        return
    numbers = [[number(value, 3) for value in row] for row in matrix.to_numpy()]
    names = [str(name) for name in matrix.index]
    show(["", *names], [(name, *row) for name, row in zip(names, numbers, strict=True)])


def succeeded(rates: Mapping[str, Mean], engines: Mapping[str, str]) -> None:
    """Print success rates by detector, with the engine and errors; a dash is a real robot."""
    show(
        ["detector", "simulated in", "attempts", "success %", "95 % interval"],
        [
            (
                *(name, engines[name] or DASH, str(rate.attempts)),
                *_rate(rate),
            )
            for name, rate in rates.items()
        ],
        without_empty=True,
    )


def hand_rates(rates: Mapping[str, Mapping[str, Mean]]) -> None:
    """Print success rates of hands, by who chose the grasps."""
    show(
        ["hand", *(title for who in rates for title in (f"{who} %", "95 % interval"))],
        [
            (name, *(text for means in rates.values() for text in _rate(means[name])))
            for name in next(iter(rates.values()))
        ],
    )


def compared(pairs: Sequence["Pair"]) -> None:
    """Print the comparison of each pair of detectors."""
    show(
        [
            "first vs second",
            *("common attempts", "difference %", "95 % interval", "p over objects"),
            *("same start", "only first", "only second", "p over these"),
        ],
        [
            (
                f"{pair.first} vs {pair.second}",
                str(pair.result.attempts),
                *_percents(pair.result.difference, pair.result.interval),
                p_value(pair.result.p_objects),
                *(_alike(pair.result) if pair.result.alike else [DASH] * 4),
            )
            for pair in pairs
        ],
        without_empty=True,
    )


def _alike(result: Comparison) -> list[str]:
    counts = (result.alike, result.only_first, result.only_second)
    return [*map(str, counts), p_value(result.p_attempts)]


def decided(tests: Mapping[tuple[str, str], SequentialTest]) -> None:
    """Print what the sequential test says about pairs of detectors."""
    show(
        ["first vs second", "pairs", "e-value", "needed", "p", "better"],
        [
            (
                *(f"{first} vs {second}", str(len(test.e_values))),
                *(f"{test.e_value:.3g}", f"{1 / test.level:g}", p_value(test.p_value)),
                _decision(test, first, second),
            )
            for (first, second), test in tests.items()
        ],
    )


def _decision(test: SequentialTest, first: str, second: str) -> str:
    if not test.better:
        return "not decided yet"
    return f"{first if test.better == 'first' else second}, after {test.decided_after} pairs"


def planned(plans: Sequence[Plan], power: float) -> None:
    """Print how many attempts show a difference, by the number of objects."""
    show(
        [
            *("objects", "attempts each", "attempts in all", "power %"),
            *(f"looking early: {100 * power:g} % decided after", "half decided after"),
        ],
        [
            (
                str(plan.objects),
                _count(plan.attempts),
                _count(plan.attempts and plan.attempts * plan.objects),
                number(100 * plan.power, 0),
                _count(plan.sequential),
                _count(plan.median),
            )
            for plan in plans
        ],
    )


def _count(value: int | None) -> str:
    return DASH if value is None else str(value)


def agreements(rows: Mapping[str, Agreement], counted: str) -> None:
    """Print how well simulated rates of objects, or detectors, agree with real ones."""
    limit = ["Pearson at most"] if counted == "objects" else []
    show(
        [
            *("over " + counted, counted, "simulated %", "real %", "real - simulated"),
            *("Spearman", "Pearson", *limit, "MMRV"),
        ],
        [
            (
                *(name, str(found.count)),
                *(number(100 * rate, 1) for rate in (found.simulated, found.real)),
                _estimate(found.difference, 1, 100),
                *(_estimate(each, 2) for each in (found.spearman, found.pearson)),
                *([number(found.limit, 2)] if limit else []),
                _estimate(found.mmrv, 3),
            )
            for name, found in rows.items()
        ],
    )


def _estimate(estimate: Estimate, digits: int, factor: float = 1) -> str:
    """A number with its interval in brackets."""
    value, low, high = (number(factor * each, digits) for each in estimate)
    return value if pd.isna(estimate.ci_low) else f"{value} ({low} to {high})"


def predicted(rates: Mapping[str, PredictedRate]) -> None:
    """Print real success rates with and without the help of objects that were only simulated."""
    show(
        [
            *("real success rate", "real objects", "only simulated", "real %", "95 % interval"),
            *("predicted %", "95 % interval", "gain"),
        ],
        [
            (
                *(name, str(found.both), str(found.simulated_only)),
                *_percents(found.plain, found.plain_interval),
                *_percents(found.value, found.interval),
                number(found.gain, 2),
            )
            for name, found in rates.items()
        ],
    )


def cleared(rates: Mapping[str, Sequence[Clearing]], engines: Mapping[str, str]) -> None:
    """Print how well detectors clear tables, with the physics engine."""
    show(
        [
            *("detector", "engine", "scenes", "noise", "rounds", "attempts"),
            *("success %", "95 % interval", "cleared %", "95 % interval"),
        ],
        [
            (
                *(name, engines[name], rate.scene, rate.noise, str(rate.rounds)),
                str(rate.success.attempts),
                *_rate(rate.success),
                *_rate(rate.cleared),
            )
            for name, each in rates.items()
            for rate in each
        ],
    )


def clearing_compared(pairs: Mapping[str, Sequence[ClearingComparison]]) -> None:
    """Print the comparison of detectors that cleared the same tables."""
    show(
        [
            *("first vs second", "scenes", "noise", "common rounds"),
            *("success +%", "95 % interval", "cleared +%", "95 % interval", "p over rounds"),
        ],
        [
            (
                *(name, found.scene, found.noise, str(found.rounds)),
                *_percents(found.success, found.success_interval),
                *_percents(found.cleared, found.cleared_interval),
                p_value(found.p_cleared),
            )
            for name, each in pairs.items()
            for found in each
        ],
    )


def terciles(table: pd.DataFrame, unit: str) -> None:
    """Print labels against simulation by terciles or values of a column: `GraspTrials.by`."""
    if (table["from"] == table["to"]).all():
        table = table.drop(columns=["from", "to"])
    texts = table.map(lambda each: each if isinstance(each, str) else f"{each:.3g}")
    rows = texts.where(table.notna(), DASH).itertuples(index=False)
    show(
        [f"by {table.columns[0]}" + (unit and f", {unit}"), *table.columns[1:]],
        rows,
        without_empty=True,
    )


def outcome_list(table: pd.DataFrame) -> str:
    """The outcomes of attempts, most frequent first: `5 success, 2 slipped lifting`."""
    counts = table["outcome"].value_counts()
    return ", ".join(f"{count} {str(name).replace('_', ' ')}" for name, count in counts.items())


def show(
    columns: Sequence[str], rows: Iterable[Sequence[str]], *, without_empty: bool = False
) -> None:
    """Print a table on stdout, possibly without columns that have only dashes."""
    rows = list(rows)
    if without_empty:
        kept = [n for n in range(len(columns)) if any(row[n] != DASH for row in rows)]
        columns, rows = [columns[n] for n in kept], [[row[n] for n in kept] for row in rows]
    table = Table(box=None, pad_edge=False, header_style="bold")
    for place, column in enumerate(columns):
        left = place == 0 or column == "nearest"
        table.add_column(column, justify="left" if left else "right", no_wrap=place == 0)
    for row in rows:
        table.add_row(*row)
    width = None if sys.stdout.isatty() else WIDE
    Console(width=width, highlight=False, markup=False).print(table)


def number(value: float, digits: int) -> str:
    """A number, or a dash if there is none."""
    return DASH if pd.isna(value) else f"{value:.{digits}f}"


def _rate(mean: Mean) -> tuple[str, str]:
    return _percents(mean.value, mean.interval)


def _percents(share: float, interval: tuple[float, float]) -> tuple[str, str]:
    """A share and its interval, in per cent."""
    return number(100 * share, 1), " to ".join(number(100 * end, 1) for end in interval)


def _rows(table: pd.DataFrame) -> list[pd.Series]:
    return [row for _, row in table.iterrows()]


def _spread(row: pd.Series) -> str:
    """Mean, lowest and highest quality in thousandths."""
    if pd.isna(row["mean"]):
        return DASH
    mean, low, high = (1000 * row[name] for name in ("mean", "low", "high"))
    return f"{mean:.2f} ({low:.2f} to {high:.2f})"


def _titles(axes: AxisPair) -> list[str]:
    return [axis.value + ("," + axis.unit if axis.unit else "") for axis in axes]


def _place(row: pd.Series, axes: AxisPair) -> tuple[str, str, str, str]:
    """Name, complexity, graspability and cell of a row."""
    unknown = pd.isna(row["complexity_cell"])
    cell = DASH if unknown else cell_name(int(row["complexity_cell"]), int(row["difficulty_cell"]))
    graspability = number(axes.upwards.factor * row["graspability"], 3)
    if not pd.isna(row["graspability_std"]):
        graspability += f" ± {number(axes.upwards.factor * row['graspability_std'], 3)}"
    return str(row["name"]), number(row["complexity"], 3), graspability, cell

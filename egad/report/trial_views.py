"""Results of trials as templates show them: each detector, and each pair of them."""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from itertools import combinations

import pandas as pd

from egad.report import trial_figures
from egad.report.axes import USUAL, AxisPair
from egad.report.heat_map import trial_heat_map
from egad.report.maps import data_uri
from egad.report.summary import outcome_counts
from egad.stats.paired import Comparison, NothingInCommonError, compare
from egad.stats.rates import Mean, Trend, TrialGrid, places, trend, trial_grid
from egad.stats.roc import discrimination, reliability


@dataclass(frozen=True)
class Set:
    """The evaluation set that was tried.

    Attributes:
        rows: Letters of the set.
        columns: Digits of the set.
        chosen: Columns of `tables.evaluation.EVAL49`; None if it is not known.
        axes: What the axes of the set are called.
    """

    rows: int
    columns: int
    chosen: pd.DataFrame | None = None
    axes: AxisPair = USUAL


@dataclass(frozen=True)
class TrialView:
    """Attempts of one detector; figures are addresses, empty if there is none.

    Attributes:
        name: The detector.
        rate: Over all attempts.
        objects: How many objects were tried.
        outcomes: Attempts by outcome.
        heat_map: Success rates of objects, rows and columns.
        reliability: Quality against success.
        discrimination: How often a success had a higher quality than a failure.
        trends: How success goes with `difficulty` and `complexity`.
        trend_figure: The same drawn.
    """

    name: str
    rate: Mean
    objects: int
    outcomes: dict[str, int]
    heat_map: str
    reliability: str
    discrimination: float
    trends: dict[str, Trend]
    trend_figure: str


@dataclass(frozen=True)
class Pair:
    """Two detectors on the same attempts; the first has the higher rate there."""

    first: str
    second: str
    result: Comparison


@dataclass(frozen=True)
class Results:
    """All detectors that tried the same set with the same gripper."""

    views: list[TrialView]
    pairs: list[Pair]
    outcome_figure: str
    rows_figure: str


def results(tables: Mapping[str, pd.DataFrame], tried: Set) -> Results:
    """Work out what there is to show.

    Args:
        tables: Attempts by detector: columns of `tables.evaluation.RESULTS`.
        tried: The evaluation set.
    """
    grids = {name: trial_grid(table, tried.rows, tried.columns) for name, table in tables.items()}
    several = len(tables) > 1
    rows = {name: [*grid.rows, grid.overall] for name, grid in grids.items()}
    return Results(
        [_view(name, table, grids[name], tried) for name, table in tables.items()],
        pairs(tables),
        _figure(trial_figures.outcome_bars(tables)) if several else "",
        _figure(trial_figures.side_by_side(rows)) if several else "",
    )


def pairs(tables: Mapping[str, pd.DataFrame]) -> list[Pair]:
    """Every two detectors compared, but for those that have no attempt in common.

    Raises:
        UserError: A label does not stand for the same object in all tables.
    """
    found = []
    for names in combinations(tables, 2):
        with suppress(NothingInCommonError):
            pair = _pair(tables, *names)
            found.append(pair if pair.result.difference >= 0 else _pair(tables, *names[::-1]))
    return found


def _pair(tables: Mapping[str, pd.DataFrame], first: str, second: str) -> Pair:
    return Pair(first, second, compare(tables[first], tables[second]))


def _view(name: str, table: pd.DataFrame, grid: TrialGrid, tried: Set) -> TrialView:
    objects = places(table, tried.chosen)
    trends = {
        key: trend(objects[key].to_numpy(), objects["rate"].to_numpy())
        for key in ("difficulty", "complexity")
    }
    means = {"difficulty": grid.rows, "complexity": grid.columns}
    present = set((table if tried.chosen is None else tried.chosen)["label"])
    bins = reliability(table)
    return TrialView(
        name=name,
        rate=grid.overall,
        objects=len(grid.cells),
        outcomes=outcome_counts(table),
        heat_map=_figure(trial_heat_map(grid, tried.rows, tried.columns, present, tried.axes)),
        reliability=_figure(trial_figures.reliability_chart({name: bins})) if bins else "",
        discrimination=discrimination(table),
        trends=trends,
        trend_figure=_figure(trial_figures.trend_chart(objects, trends, means, tried.axes)),
    )


def _figure(svg: str) -> str:
    return data_uri(svg.encode(), "image/svg+xml")

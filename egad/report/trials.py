"""The section Simulated trials, and a page about trials alone: each detector, and each pair."""

import string
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from egad.bench.stats import (
    Bin,
    Comparison,
    Mean,
    NothingInCommonError,
    Trend,
    TrialGrid,
    compare,
    discrimination,
    object_positions,
    reliability,
    simulated_in,
    trend,
    trial_grid,
)
from egad.evalset import cell_of_label
from egad.report.axes import USUAL, AxisPair
from egad.report.colors import LINES, SOFT, line_color
from egad.report.drawing import DASHED, new_figure, show_percent
from egad.report.page import Section, render_template, section_of, svg_uri
from egad.report.trial_charts import (
    draw_intervals,
    draw_rates,
    outcome_chart,
    outcome_counts,
    rate_bars,
    trial_chart,
    trial_heat_map,
)


@dataclass(frozen=True)
class EvaluationSet:
    """The evaluation set that was tried: letters, digits, `EVAL49` if known, names of the axes."""

    rows: int
    columns: int
    objects: pd.DataFrame | None = None
    axes: AxisPair = USUAL


@dataclass(frozen=True)
class TrialView:
    """Attempts of one detector; figures are addresses, empty if there is none."""

    name: str
    engine: str  # the physics engine, and the errors of the cell; empty for a real robot
    rate: Mean  # success rate over all attempts
    objects: int
    outcomes: dict[str, int]
    # success rates of objects, rows and columns; outcomes by object if the set is not a grid
    heat_map: str
    reliability: str  # quality against success
    discrimination: float  # how often a success had a higher quality than a failure
    trends: dict[str, Trend]  # rank correlation of success with `difficulty` and `complexity`
    trend_figure: str  # the same as a figure; none if the set is not a grid


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


def section(
    results: Mapping[str, Mapping[str, Results]], *, attempts: int, lift_height: float
) -> Section:
    """The trials of each dataset with each gripper; the lift height is that of success, metres."""
    views = [view for each in results.values() for one in each.values() for view in one.views]
    in_grid = any(view.trend_figure for view in views)
    values = {"attempts": attempts, "lift_height": lift_height, "in_grid": in_grid}
    return section_of("trials.html.j2", "Trials", datasets=results, **values)


def page(
    tables: Mapping[str, pd.DataFrame],
    evaluation_set: EvaluationSet,
    conclusions: Sequence[str] = (),
) -> str:
    """An HTML page of `tables.evaluation.RESULTS` by detector that needs no other file."""
    results = trial_results(tables, evaluation_set)
    return render_template("trials_page.html.j2", results=results, conclusions=conclusions)


def trial_results(tables: Mapping[str, pd.DataFrame], evaluation_set: EvaluationSet) -> Results:
    """Compute what the section shows from `tables.evaluation.RESULTS` by detector."""
    rows, columns = evaluation_set.rows, evaluation_set.columns
    grids = {name: trial_grid(table, rows, columns) for name, table in tables.items()}
    several = len(tables) > 1
    in_rows = several and all(grid.rows for grid in grids.values())
    rates = {name: [*grid.rows, grid.overall] for name, grid in grids.items()}
    return Results(
        [_view(name, table, grids[name], evaluation_set) for name, table in tables.items()],
        pairs(tables),
        svg_uri(outcome_chart(tables)) if several else "",
        svg_uri(rate_bars(rates)) if in_rows else "",
    )


def pairs(tables: Mapping[str, pd.DataFrame]) -> list[Pair]:
    """Compare every two detectors with common attempts; UserError if a label means two objects."""
    found = []
    for names in combinations(tables, 2):
        with suppress(NothingInCommonError):
            pair = _pair(tables, *names)
            found.append(pair if pair.result.difference >= 0 else _pair(tables, *names[::-1]))
    return found


def _pair(tables: Mapping[str, pd.DataFrame], first: str, second: str) -> Pair:
    return Pair(first, second, compare(tables[first], tables[second]))


def _view(
    name: str, table: pd.DataFrame, grid: TrialGrid, evaluation_set: EvaluationSet
) -> TrialView:
    known, axes = evaluation_set.objects, evaluation_set.axes
    objects = object_positions(table, known)
    trends = {
        key: trend(objects[key].to_numpy(), objects["rate"].to_numpy())
        for key in ("difficulty", "complexity")
    }
    means = {"difficulty": grid.rows, "complexity": grid.columns}
    present = set((table if known is None else known)["label"])
    bins = reliability(table)
    several = len(bins) > 1  # qualities
    return TrialView(
        name=name,
        engine=simulated_in(table),
        rate=grid.overall,
        objects=len(objects),
        outcomes=outcome_counts(table),
        heat_map=svg_uri(
            trial_heat_map(grid, evaluation_set.rows, evaluation_set.columns, present, axes)
            if grid.rows
            else trial_chart(table)
        ),
        reliability=svg_uri(reliability_chart(bins)) if several else "",
        discrimination=discrimination(table) if several else np.nan,
        trends=trends,
        trend_figure=svg_uri(trend_chart(objects, trends, means, axes)) if grid.rows else "",
    )


def reliability_chart(bins: Sequence[Bin]) -> str:
    """SVG of success rate over quality, Wilson intervals of 95 %; a diagonal from 0 to 1."""
    qualities = [each.quality for each in bins]
    with new_figure(3.7, 3.0) as drawing:
        axes = drawing.figure.add_subplot()
        draw_rates(axes, qualities, [each.rate for each in bins], line_color(0))
        if min(qualities) >= 0 and 0.1 < max(qualities) <= 1:
            axes.plot([0, 1], [0, 1], color=SOFT, lw=0.8, ls=DASHED, zorder=0)
        axes.set(ylim=(-0.02, 1.02), xlabel="quality predicted by the detector")
        axes.set_ylabel("success rate")
        show_percent(axes.yaxis)
        axes.grid(axis="y")
    return drawing.svg


def trend_chart(
    objects: pd.DataFrame,
    trends: Mapping[str, Trend],
    means: Mapping[str, Sequence[Mean]],
    names: AxisPair = USUAL,
) -> str:
    """SVG of the success of each object against its difficulty and complexity, with means."""
    keys = {"difficulty": names.upwards, "complexity": names.across}
    with new_figure(8.6, 3.0) as drawing:
        panels = drawing.figure.subplots(1, 2, sharey=True)
        for axes, (key, axis) in zip(panels, keys.items(), strict=True):
            _draw_trend(axes, objects, key, means[key], letters=key == "difficulty")
            axes.set_xlabel(axis.label)
            axes.set_title(_trend_text(trends[key]), fontsize=9, color=SOFT)
            axes.grid(axis="y")
        panels[0].set(ylim=(-0.04, 1.04), ylabel="success rate")
        show_percent(panels[0].yaxis)
    return drawing.svg


def _draw_trend(
    axes: Axes, objects: pd.DataFrame, key: str, means: Sequence[Mean], *, letters: bool
) -> None:
    labels = objects.index.astype(str)
    cells = [cell_of_label(label)[0 if letters else 1] for label in labels]
    groups = objects[key].groupby(cells)
    beside = (groups.rank() - 0.5) / groups.transform("size") - 0.5
    axes.plot(np.array(cells) + 0.7 * beside, objects["rate"], "o", color=LINES[5], ms=4, alpha=0.7)
    known = [(cell, mean.value) for cell, mean in enumerate(means) if mean.attempts]
    axes.plot(*np.reshape(known, (-1, 2)).T, "o-", color=LINES[0], ms=5, lw=1.6)
    draw_intervals(axes, range(len(means)), means, LINES[0])
    ticks = list(string.ascii_uppercase[: len(means)]) if letters else range(len(means))
    axes.set_xticks(range(len(means)), [str(tick) for tick in ticks])
    axes.set_xlim(-0.5, len(means) - 0.5)
    axes.tick_params(axis="x", length=0)


def _trend_text(trend: Trend) -> str:
    if np.isnan(trend.rho):
        return "no rank correlation: too few objects, or all values are equal"
    rho, low, high = (
        f"{round(end, 2) + 0:.2f}" for end in (trend.rho, trend.ci_low, trend.ci_high)
    )
    return f"rank correlation {rho} ({low} to {high})".replace("-", "\N{MINUS SIGN}")

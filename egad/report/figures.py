"""Charts of the report, as SVG text."""

import string
from collections.abc import Mapping
from typing import Any

import matplotlib
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.patches import Rectangle

from egad.report.axes import USUAL, AxisPair
from egad.report.style import FAINT, INK, LINES, SOFT, drawn, ink_on
from egad.report.summary import PUBLISHED, outcome_counts
from egad.trials.statistics import Rate, TrialGrid

OUTCOMES = {
    "success": "#0072b2",
    "slipped": "#56b4e9",
    "dropped": "#009e73",
    "missed": "#e69f00",
    "collided": "#d55e00",
    "no_grasp": "#cc79a7",
    "failed": "#a7adb8",
}
GAP = 0.35
DASH = "\N{EN DASH}"
THOUSANDTHS = "\N{MULTIPLICATION SIGN} 10\N{SUPERSCRIPT THREE}"


def trial_heat_map(
    grid: TrialGrid, rows: int, columns: int, present: set[str], axis_names: AxisPair = USUAL
) -> str:
    """Success rate of every object, with the rates of whole rows and columns beside it.

    Args:
        grid: Rates from `egad.trials.statistics.trial_grid`.
        rows: Letters of the evaluation set; the easiest is drawn at the bottom.
        columns: Digits of the evaluation set.
        present: Labels of the objects in the set; all other places are drawn empty.
        axis_names: What is written along the axes.

    Returns:
        SVG text.
    """
    with drawn(0.8 + 0.62 * (columns + 1.62), 0.6 + 0.62 * (rows + 1.37)) as drawing:
        axes = drawing.figure.add_subplot()
        for row in range(rows):
            for column in range(columns):
                label = f"{string.ascii_uppercase[row]}{column}"
                _heat_cell(axes, column, row, grid.cells.get((row, column)), label in present)
        for row, rate in enumerate(grid.rows):
            _heat_cell(axes, columns + GAP, row, rate, True, 1.25)
        for column, rate in enumerate(grid.columns):
            _heat_cell(axes, column, -1 - GAP, rate, True)
        _heat_cell(axes, columns + GAP, -1 - GAP, grid.overall, True, 1.25)
        _heat_axes(axes, rows, columns, axis_names)
    return drawing.svg


def _heat_cell(
    axes: Axes, x: float, y: float, rate: Rate | None, present: bool, width: float = 1
) -> None:
    margin = x != int(x) or y != int(y)
    tried = rate is not None and rate.attempts > 0
    shade = 0.06 + 0.84 * rate.value if rate is not None and tried else 0
    colour = to_hex(matplotlib.colormaps["Blues"](shade)) if tried else "#ffffff"
    box = Rectangle((x + 0.02, y + 0.02), width - 0.04, 0.96, facecolor=colour, lw=0)
    if not tried:
        box.set(edgecolor=FAINT, lw=0.8, hatch=None if present else "////")
    axes.add_patch(box)
    ink = ink_on(colour)
    centre = x + width / 2
    if not tried or rate is None:
        axes.text(centre, y + 0.5, DASH if present else "", ha="center", va="center", color=SOFT)
        return
    low, high = (round(100 * end) for end in rate.interval)
    below = f"{low}{DASH}{high}" if margin else f"{rate.successes}/{rate.attempts}"
    weight = "bold" if margin else "normal"
    text = f"{rate.value * 100:.0f}"
    axes.text(centre, y + 0.58, text, ha="center", va="center", color=ink, weight=weight, size=11)
    axes.text(centre, y + 0.24, below, ha="center", va="center", color=ink, size=7)


def _heat_axes(axes: Axes, rows: int, columns: int, names: AxisPair) -> None:
    axes.set(xlim=(-0.02, columns + GAP + 1.27), ylim=(-1 - GAP - 0.02, rows + 0.02))
    axes.set_aspect("equal")
    axes.set_xticks(
        [*(np.arange(columns) + 0.5), columns + GAP + 0.625],
        [*map(str, range(columns)), "mean"],
    )
    axes.set_yticks(
        [-0.5 - GAP, *(np.arange(rows) + 0.5)], ["mean", *string.ascii_uppercase[:rows]]
    )
    axes.tick_params(length=0)
    axes.spines[:].set_visible(False)
    axes.set_xlabel(names.across.label)
    axes.set_ylabel(names.upwards.label)


def outcome_bars(trials: Mapping[str, pd.DataFrame]) -> str:
    """Outcomes of the attempts, one bar a table.

    Args:
        trials: Tables with the columns of `tables.evaluation.TRIALS`, by the name of the bar.

    Returns:
        SVG text.
    """
    with drawn(8.6, 0.75 + 0.42 * len(trials)) as drawing:
        axes = drawing.figure.add_subplot()
        counts = {name: outcome_counts(table) for name, table in trials.items()}
        for place, row in enumerate(counts.values()):
            _outcome_bar(axes, -place, row)
        axes.set_yticks([-place for place in range(len(counts))], list(counts))
        axes.tick_params(axis="y", length=0)
        axes.set(xlim=(0, 1), ylim=(-len(counts) + 0.45, 0.55))
        axes.xaxis.set_major_formatter(lambda value, _: f"{value:.0%}")
        axes.spines[["left"]].set_visible(False)
        used = [name for name in OUTCOMES if any(name in row for row in counts.values())]
        handles = [Rectangle((0, 0), 1, 1, facecolor=OUTCOMES[name]) for name in used]
        names = [name.replace("_", " ") for name in used]
        drawing.figure.legend(handles, names, loc="outside upper center", ncols=7, fontsize=9)
    return drawing.svg


def _outcome_bar(axes: Axes, place: float, counts: Mapping[str, int]) -> None:
    total, start = sum(counts.values()), 0.0
    for name, colour in OUTCOMES.items():
        part = counts.get(name, 0) / total
        axes.barh(place, part, left=start, height=0.62, color=colour, edgecolor="white", lw=0.6)
        if part > 0.03:
            ink = "white" if name in ("success", "dropped", "collided") else INK
            middle = start + part / 2
            axes.text(middle, place, str(counts[name]), ha="center", va="center", color=ink, size=9)
        start += part


def grasp_distributions(grasps: Mapping[str, pd.DataFrame]) -> str:
    """Histograms of plain and robust grasp quality, one line a gripper.

    Args:
        grasps: Tables with the columns of `tables.grasping.GRASPS`, by gripper.

    Returns:
        SVG text.
    """
    panels = {
        "quality": f"quality {THOUSANDTHS}",
        "robust_quality": f"robust quality {THOUSANDTHS}",
    }
    with drawn(8.6, 2.7) as drawing:
        left, right = drawing.figure.subplots(1, 2)
        for axes, (column, title) in zip((left, right), panels.items(), strict=True):
            _histograms(axes, {name: table[column] * 1000 for name, table in grasps.items()})
            axes.set_xlabel(title)
        left.set_ylabel("share of the grasps")
        if len(grasps) > 1:
            drawing.figure.legend(
                *left.get_legend_handles_labels(), loc="outside upper center", ncols=5
            )
    return drawing.svg


def _histograms(axes: Axes, values: Mapping[str, "pd.Series[float]"]) -> None:
    known = np.concatenate([series.dropna() for series in values.values()])
    top = known.max() if len(known) and known.max() > 0 else 1.0
    bins = np.linspace(min(0, known.min(initial=0)), top, 41)
    for place, (name, series) in enumerate(values.items()):
        colour = LINES[place % len(LINES)]
        share = np.histogram(series.dropna(), bins)[0] / max(len(series), 1)
        axes.stairs(share, bins, color=colour, lw=1.6, label=name)
        axes.stairs(share, bins, color=colour, fill=True, alpha=0.12)
    axes.set(xlim=(bins[0], bins[-1]))
    axes.set_ylim(bottom=0)
    axes.yaxis.set_major_formatter(lambda value, _: f"{value:.0%}")
    axes.grid(axis="y")


def comparison_chart(comparison: pd.DataFrame) -> str:
    """Places filled and span of diversity of datasets, with the published ones below.

    Args:
        comparison: Columns of `tables.objects.COMPARISON`.

    Returns:
        SVG text.
    """
    ours = comparison.to_dict("records")
    theirs = PUBLISHED.to_dict("records")
    with drawn(8.6, 0.8 + 0.3 * (len(ours) + len(theirs))) as drawing:
        left, right = drawing.figure.subplots(1, 2, sharey=True)
        for place, row in enumerate([*ours, *theirs]):
            _comparison_row(left, right, -place, row, place < len(ours))
        names = [str(row["dataset"]) for row in ours]
        names += [f"{row['dataset']} (published)" for row in theirs]
        left.set_yticks([-place for place in range(len(names))], names)
        left.set(xlim=(0, 1), xlabel="coverage")
        left.xaxis.set_major_formatter(lambda value, _: f"{value:.0%}")
        right.set(xlabel="diversity: least, mean, greatest")
        right.set_xlim(left=0)
        for axes in (left, right):
            axes.tick_params(axis="y", length=0)
            axes.spines["left"].set_visible(False)
            axes.grid(axis="x")
    return drawing.svg


def _comparison_row(
    left: Axes, right: Axes, place: float, row: Mapping[Any, Any], own: bool
) -> None:
    colour = LINES[0] if own else SOFT
    left.barh(place, row["coverage"], height=0.55, color=colour, alpha=1 if own else 0.55)
    right.hlines(place, row["diversity_min"], row["diversity_max"], color=colour, lw=2)
    face = colour if own else "white"
    right.plot(row["diversity_mean"], place, "o", color=colour, markerfacecolor=face, ms=6)

"""Charts of the report, as SVG text."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from egad.report.style import LINES, SOFT, drawn
from egad.report.summary import PUBLISHED

THOUSANDTHS = "\N{MULTIPLICATION SIGN} 10\N{SUPERSCRIPT THREE}"


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

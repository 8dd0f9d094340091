"""The chart of grasp quality over the size of objects, as SVG text."""

import math

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from egad.measures.size_effect import summarised
from egad.report.style import FAINT, INK, LINES, SOFT, drawn

COLUMNS = 3
WIDTH, HEIGHT = 3.2, 3.7
THOUSANDTHS = "\N{MULTIPLICATION SIGN} 10\N{SUPERSCRIPT THREE}"


def size_chart(table: pd.DataFrame) -> str:
    """Percentiles of quality over size, a panel an object, all on the same axes.

    A line is the mean over repetitions, its band goes from the lowest to the highest; a point is
    hollow where only some repetitions found grasps. Beneath is the share of candidates that are
    possible grasps.

    Args:
        table: Columns of `tables.grasping.SIZE_EFFECT`, at least one row.

    Returns:
        SVG text.
    """
    numbers = summarised(table)
    names = list(dict.fromkeys(numbers["name"]))
    columns = min(COLUMNS, len(names))
    rows = math.ceil(len(names) / columns)
    with drawn(WIDTH * columns + 0.8, HEIGHT * rows + 0.5) as drawing:
        grid = drawing.figure.subplots(
            2 * rows, columns, squeeze=False, sharex=True, sharey="row", height_ratios=[3, 1] * rows
        )
        highest = 1000 * float(np.nanmax([*numbers["high"], 0.0])) or 1.0
        for place, name in enumerate(names):
            row, column = divmod(place, columns)
            upper, lower = grid[2 * row, column], grid[2 * row + 1, column]
            shown = numbers[numbers["name"] == name]
            _quality(upper, shown, highest, labelled=place == 0)
            upper.set_title(name, size=10)
            _share(lower, shown)
            lower.tick_params(labelbottom=True)
        for place in range(len(names), rows * columns):
            row, column = divmod(place, columns)
            grid[2 * row, column].set_axis_off()
            grid[2 * row + 1, column].set_axis_off()
        for row in range(rows):
            grid[2 * row, 0].set_ylabel(f"quality {THOUSANDTHS}")
            grid[2 * row + 1, 0].set_ylabel("possible")
        drawing.figure.supxlabel("smallest side / opening of the gripper", size=10)
        handles, titles = grid[0, 0].get_legend_handles_labels()
        drawing.figure.legend(handles, titles, loc="outside upper center", ncols=4)
    return drawing.svg


def _quality(axes: Axes, numbers: pd.DataFrame, highest: float, *, labelled: bool) -> None:
    for place, (percent, line) in enumerate(numbers.groupby("percentile")):
        known = line.dropna(subset=["mean"])
        colour = LINES[place % len(LINES)]
        size = known["fraction"]
        axes.fill_between(size, 1000 * known["low"], 1000 * known["high"], color=colour, alpha=0.2)
        label = f"percentile {percent:g}" if labelled else None
        axes.plot(size, 1000 * known["mean"], color=colour, lw=1.6, label=label)
        for whole, face in ((True, colour), (False, "white")):
            points = known[(known["found"] == 1) == whole]
            across, height = points["fraction"], 1000 * points["mean"]
            axes.plot(across, height, "o", ms=4, color=colour, mfc=face, zorder=3)
    axes.axvline(1, color=SOFT, lw=0.8, ls=":")
    axes.set_ylim(0, 1.05 * highest)
    axes.grid(axis="y")


def _share(axes: Axes, numbers: pd.DataFrame) -> None:
    shares = numbers.drop_duplicates("fraction")
    axes.fill_between(shares["fraction"], shares["share"], color=FAINT)
    axes.plot(shares["fraction"], shares["share"], color=INK, lw=1)
    axes.axvline(1, color=SOFT, lw=0.8, ls=":")
    axes.set_ylim(0, 1)
    axes.set_yticks([0, 0.5, 1])
    axes.yaxis.set_major_formatter(lambda value, _: f"{value:.0%}")

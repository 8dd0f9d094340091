"""Success rates over the grid of the evaluation set, as the paper shows them."""

import string

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.patches import Rectangle

from egad.evalset.selection import label_at
from egad.report.axes import USUAL, AxisPair
from egad.report.style import FAINT, SOFT, drawn, ink_on
from egad.stats.rates import Rate, TrialGrid

GAP = 0.35
DASH = "\N{EN DASH}"


def trial_heat_map(
    grid: TrialGrid, rows: int, columns: int, present: set[str], axis_names: AxisPair = USUAL
) -> str:
    """Success rate of every object, with the rates of whole rows and columns beside it.

    Args:
        grid: Rates from `egad.stats.rates.trial_grid`.
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
                label = label_at(row, column)
                _heat_cell(axes, column, row, grid.cells.get((row, column)), label in present)
        for row, rate in enumerate(grid.rows):
            _heat_cell(axes, columns + GAP, row, rate, True, 1.25)
        for column, rate in enumerate(grid.columns):
            _heat_cell(axes, column, -1 - GAP, rate, True)
        _heat_cell(axes, columns + GAP, -1 - GAP, grid.overall, True, 1.25)
        _heat_axes(axes, rows, columns, axis_names)
    return drawing.svg


def rate_colour(value: float) -> str:
    """The blue of a success rate, as `#rrggbb`: the higher, the darker."""
    return to_hex(matplotlib.colormaps["Blues"](0.06 + 0.84 * value))


def _heat_cell(
    axes: Axes, x: float, y: float, rate: Rate | None, present: bool, width: float = 1
) -> None:
    margin = x != int(x) or y != int(y)
    tried = rate is not None and rate.attempts > 0
    colour = rate_colour(rate.value) if rate is not None and tried else "#ffffff"
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
    counts = [] if margin else [f"{rate.successes}/{rate.attempts}"]
    below = [*counts, f"{low}{DASH}{high}"]
    top = 0.5 + 0.12 * len(below)
    weight = "bold" if margin else "normal"
    text = f"{rate.value * 100:.0f}"
    axes.text(centre, y + top, text, ha="center", va="center", color=ink, weight=weight, size=11)
    for line, small in enumerate(below, 1):
        height = y + top - 0.1 - 0.21 * line
        axes.text(centre, height, small, ha="center", va="center", color=ink, size=6.5)


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

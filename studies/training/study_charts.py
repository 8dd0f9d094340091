"""Charts of the training study: success of sets, each network as a point, and learning curves."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from egad.report.colors import INK, LINES, SOFT, line_color
from egad.report.drawing import new_figure, show_percent

LEFT = "\N{LEFTWARDS ARROW}"


@dataclass(frozen=True)
class Row:
    """Success of a training set, or of another detector, in a test.

    Attributes:
        values: One value for each network, or a single one for another detector.
        trained: Whether its networks were trained, rather than given.
        interval: 95 % confidence interval of the mean over networks; NaN if it is not known.
    """

    values: Sequence[float]
    trained: bool
    interval: tuple[float, float]

    @property
    def mean(self) -> float:
        """Mean over the networks."""
        return float(np.mean(self.values))


def success_chart(tests: Mapping[str, Mapping[str, Row]]) -> str:
    """Success of each training set, a panel per test.

    Args:
        tests: Rows by name, by title of the panel. A panel may lack some of the names.

    Returns:
        SVG text: a filled dot is the mean of the networks of a set, with its interval of 95 %;
        hollow dots are single networks; other detectors are grey. The axis begins below the lowest
        training set; detectors that are lower stand at its beginning, as numbers.
    """
    names = list(dict.fromkeys(name for rows in tests.values() for name in rows))
    lowest = _axis_start(
        value
        for rows in tests.values()
        for row in rows.values()
        if row.trained
        for value in (*row.values, row.interval[0])
    )
    across = min(len(tests), 2)
    down = -(-len(tests) // across)
    with new_figure(1.6 + 3.7 * across, down * (0.9 + 0.3 * len(names))) as drawing:
        panels = drawing.figure.subplots(down, across, squeeze=False, sharey=True)
        for axes, (title, rows) in zip(panels.flat, tests.items(), strict=False):
            axes.set(xlim=(lowest, 1), ylim=(len(names) - 0.5, -0.5))
            for name, row in rows.items():
                _draw_row(axes, names.index(name), row)
            axes.set_title(title, fontsize=10)
            axes.set_yticks(range(len(names)), names)
            axes.xaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
            show_percent(axes.xaxis)
            axes.tick_params(axis="y", length=0)
            axes.grid(axis="x")
        for axes in panels.flat[len(tests) :]:
            axes.remove()
        drawing.figure.supxlabel("success rate", fontsize=10, color=INK)
    return drawing.svg


def _axis_start(values: Iterable[float]) -> float:
    """The lowest value, rounded down to a tenth, so that small differences are seen."""
    known = [value for value in values if not np.isnan(value)]
    return max(0.0, math.floor(10 * min(known, default=0)) / 10)


def _draw_row(axes: Axes, y: float, row: Row) -> None:
    color = LINES[0] if row.trained else SOFT
    start = axes.get_xlim()[0]
    if row.mean < start:
        axes.text(start, y, f" {LEFT} {row.mean:.0%}", va="center", fontsize=9, color=color)
        return
    axes.hlines(y, *row.interval, color=color, lw=1.6)
    axes.plot([row.mean], [y], "o", ms=5.5, color=color)
    if len(row.values) > 1:
        dots = [y + 0.24] * len(row.values)
        axes.plot(row.values, dots, "o", ms=3.5, color=INK, mfc="none", mew=0.7)


def learning_chart(curves: Mapping[str, Sequence[tuple[float, Row]]], label: str) -> str:
    """Success over the size of the training set.

    Args:
        curves: By test: sizes of sets and their success.
        label: What the size counts.

    Returns:
        SVG text: a line joins the means, with intervals of 95 % over networks; hollow dots are
        single networks.
    """
    with new_figure(7.6, 3.2) as drawing:
        axes = drawing.figure.add_subplot()
        for number, (name, points) in enumerate(curves.items()):
            color = line_color(number)
            sizes, means = zip(*((size, row.mean) for size, row in points), strict=True)
            axes.plot(sizes, means, "o-", ms=5, lw=1.4, color=color, label=name)
            for size, row in points:
                axes.vlines(size, *row.interval, color=color, lw=1)
                dots = [size] * len(row.values)
                axes.plot(dots, row.values, "o", ms=3.5, color=color, mfc="none")
        ticks = sorted({size for each in curves.values() for size, _ in each})
        axes.set_xscale("log")
        axes.set_xticks(ticks, [f"{size:,.0f}" for size in ticks])
        axes.minorticks_off()
        lowest = _axis_start(v for each in curves.values() for _, row in each for v in row.values)
        axes.set(ylim=(lowest, 1), xlabel=label, ylabel="success rate")
        axes.yaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
        show_percent(axes.yaxis)
        axes.grid(axis="y")
        drawing.figure.legend(loc="outside upper center", ncols=4, fontsize=9)
    return drawing.svg

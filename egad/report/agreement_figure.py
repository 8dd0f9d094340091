"""The chart of labelled grasps that were carried out, as SVG text."""

import string
from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes

from egad.report.style import LINES, SOFT, drawn
from egad.stats.roc import Area, Bin


def agreement_chart(bins: Mapping[str, Sequence[Bin]], areas: Mapping[str, Sequence[Area]]) -> str:
    """Success over the rank by quality, and how well each quality tells in each row of the set.

    Args:
        bins: From `egad.stats.roc`, by quality.
        areas: Of each row of the evaluation set, and then the one over all, by quality.

    Returns:
        SVG text; intervals are of 95 %: left for other grasps of the same objects, right for other
        objects. A bin lies where its grasps are among all, from worst to
        best; grasps of equal quality are one bin.
    """
    with drawn(8.6, 3.2) as drawing:
        left, right = drawing.figure.subplots(1, 2, width_ratios=[1, 1.25])
        for number, (name, each) in enumerate(bins.items()):
            if each:
                _over_rank(left, each, LINES[number], name)
        left.set(xlim=(0, 1), xlabel="grasps by quality, worst to best", ylabel="success rate")
        for axis in (left.xaxis, left.yaxis):
            axis.set_major_formatter(lambda value, _: f"{value:.0%}")
        left.grid(axis="y")
        for number, row in enumerate(areas.values()):
            _by_row(right, row, LINES[number], 0.24 * (number - (len(areas) - 1) / 2))
        right.axhline(0.5, color=SOFT, lw=0.8, ls=(0, (4, 4)))
        count = max(map(len, areas.values()))
        right.set_xticks(range(count), [*string.ascii_uppercase[: count - 1], "all"])
        right.tick_params(axis="x", length=0)
        right.set(ylim=(0, 1.02), xlabel="row, easy to hard", ylabel="area under the ROC curve")
        right.grid(axis="y")
        drawing.figure.legend(
            *left.get_legend_handles_labels(), loc="outside upper center", ncols=3
        )
    return drawing.svg


def _over_rank(axes: Axes, bins: Sequence[Bin], colour: str, name: str) -> None:
    counts = np.array([each.rate.attempts for each in bins])
    x = (np.cumsum(counts) - counts / 2) / counts.sum()
    rates = [each.rate for each in bins]
    axes.vlines(x, *zip(*(rate.interval for rate in rates), strict=True), color=colour, lw=1)
    axes.plot(x, [rate.value for rate in rates], "o-", color=colour, ms=4.5, lw=1.4, label=name)


def _by_row(axes: Axes, areas: Sequence[Area], colour: str, aside: float) -> None:
    for place, area in enumerate(areas):
        axes.plot(place + aside, area.value, "o", color=colour, ms=5)
        axes.vlines(place + aside, *area.interval, color=colour, lw=1)

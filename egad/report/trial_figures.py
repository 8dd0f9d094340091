"""Charts of trials, as SVG text: outcomes, reliability, trends, and two detectors side by side."""

import string
from collections.abc import Iterable, Mapping, Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle

from egad.evalset.selection import place
from egad.report.axes import USUAL, AxisPair
from egad.report.style import FAINT, INK, LINES, SOFT, drawn
from egad.report.summary import outcome_counts
from egad.stats.rates import Mean, Trend
from egad.stats.roc import Bin

OUTCOMES = {
    "success": "#0072b2",
    "slipped_closing": "#9bd5f5",
    "slipped_lifting": "#56b4e9",
    "slipped": "#2f8fc4",
    "dropped": "#009e73",
    "missed": "#e69f00",
    "collided": "#d55e00",
    "no_grasp": "#cc79a7",
    "not_finite": "#b0568a",
    "too_wide": "#943f72",
    "below_table": "#77295a",
    "error": "#591443",
    "timeout": "#3c002d",
    "failed": "#a7adb8",
    "crashed": "#5c6470",
    "other": "#7d8591",
}
DARK = (
    *("success", "slipped", "dropped", "collided", "too_wide", "below_table", "error", "timeout"),
    "crashed",
)
PERCENT = "{:.0%}".format


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
            ink = "white" if name in DARK else INK
            middle = start + part / 2
            axes.text(middle, place, str(counts[name]), ha="center", va="center", color=ink, size=9)
        start += part


def reliability_chart(bins: Mapping[str, Sequence[Bin]]) -> str:
    """Success rate against the quality that a detector gave, with Wilson intervals of 95 %.

    Args:
        bins: From `egad.stats.roc`, by detector.

    Returns:
        SVG text. If all qualities lie between 0 and 1, a diagonal shows where they would be the
        chance of success.
    """
    shown = {name: each for name, each in bins.items() if each}
    with drawn(3.7, 3.0) as drawing:
        axes = drawing.figure.add_subplot()
        for place, (name, each) in enumerate(shown.items()):
            _with_intervals(axes, [b.quality for b in each], each, LINES[place % len(LINES)], name)
        qualities = [b.quality for each in shown.values() for b in each]
        if qualities and min(qualities) >= 0 and 0.1 < max(qualities) <= 1:
            axes.plot([0, 1], [0, 1], color=SOFT, lw=0.8, ls=(0, (4, 4)), zorder=0)
        axes.set(ylim=(-0.02, 1.02), xlabel="quality that the detector gave", ylabel="success rate")
        axes.yaxis.set_major_formatter(lambda value, _: PERCENT(value))
        axes.grid(axis="y")
        if len(shown) > 1:
            drawing.figure.legend(loc="outside upper center", ncols=3, fontsize=9)
    return drawing.svg


def _with_intervals(
    axes: Axes, x: Sequence[float], bins: Sequence[Bin], colour: str, name: str
) -> None:
    rates = [each.rate for each in bins]
    axes.vlines(x, *zip(*(rate.interval for rate in rates), strict=True), color=colour, lw=1)
    axes.plot(x, [rate.value for rate in rates], "o-", color=colour, ms=4.5, lw=1.4, label=name)


def trend_chart(
    objects: pd.DataFrame,
    trends: Mapping[str, Trend],
    means: Mapping[str, Sequence[Mean]],
    names: AxisPair = USUAL,
) -> str:
    """Success of each object against its difficulty and its complexity.

    Args:
        objects: Columns label (the index), rate, difficulty and complexity.
        trends: Rank correlation of each.
        means: Rates of whole rows and columns of the evaluation set: `difficulty`, `complexity`.
        names: What the axes are called.

    Returns:
        SVG text: a dot an object, spread sideways by its value within the row or column; the
        lines join the means, with their intervals of 95 %.
    """
    keys = {"difficulty": names.upwards, "complexity": names.across}
    with drawn(8.6, 3.0) as drawing:
        for axes, (key, axis) in zip(
            drawing.figure.subplots(1, 2, sharey=True), keys.items(), strict=True
        ):
            letters = key == "difficulty"
            _trend_panel(axes, objects, key, means[key], letters)
            axes.set_xlabel(axis.label)
            axes.set_title(_trend_text(trends[key]), fontsize=9, color=SOFT)
            axes.grid(axis="y")
        drawing.figure.axes[0].set(ylim=(-0.04, 1.04), ylabel="success rate")
        drawing.figure.axes[0].yaxis.set_major_formatter(lambda value, _: PERCENT(value))
    return drawing.svg


def _trend_panel(
    axes: Axes, objects: pd.DataFrame, key: str, means: Sequence[Mean], letters: bool
) -> None:
    labels = objects.index.astype(str)
    cells = [place(label)[0 if letters else 1] for label in labels]
    groups = objects[key].groupby(cells)
    beside = (groups.rank() - 0.5) / groups.transform("size") - 0.5
    axes.plot(np.array(cells) + 0.7 * beside, objects["rate"], "o", color=LINES[5], ms=4, alpha=0.7)
    known = [(cell, mean.value) for cell, mean in enumerate(means) if mean.attempts]
    axes.plot(*np.reshape(known, (-1, 2)).T, "o-", color=LINES[0], ms=5, lw=1.6)
    _whiskers(axes, range(len(means)), means, LINES[0])
    ticks = list(string.ascii_uppercase[: len(means)]) if letters else range(len(means))
    axes.set_xticks(range(len(means)), [str(tick) for tick in ticks])
    axes.set_xlim(-0.5, len(means) - 0.5)
    axes.tick_params(axis="x", length=0)


def _whiskers(axes: Axes, x: Iterable[float], means: Sequence[Mean], colour: str) -> None:
    """Intervals of rates, but for those of which nothing is known."""
    for at, mean in zip(x, means, strict=True):
        low, high = mean.interval
        if (low, high) != (0.0, 1.0):
            axes.vlines(at, low, high, color=colour, lw=1)


def _trend_text(trend: Trend) -> str:
    if np.isnan(trend.rho):
        return "no rank correlation: all the same"
    rho, low, high = (f"{round(end, 2) + 0:.2f}" for end in (trend.rho, trend.low, trend.high))
    return f"rank correlation {rho} ({low} to {high})".replace("-", "\N{MINUS SIGN}")


def side_by_side(
    rows: Mapping[str, Sequence[Mean]], called: Sequence[str] = string.ascii_uppercase
) -> str:
    """Success rates of detectors by row of the evaluation set, with intervals of 95 %.

    Args:
        rows: Rates of each row, and then the one over all, by detector.
        called: Names of the rows; or of the columns, if these are given.

    Returns:
        SVG text.
    """
    count = max(len(each) for each in rows.values())
    with drawn(8.6, 3.2) as drawing:
        axes = drawing.figure.add_subplot()
        step = 0.7 / len(rows)
        for number, (name, means) in enumerate(rows.items()):
            x = np.arange(count) + (number - (len(rows) - 1) / 2) * step
            x[-1] += 0.35
            colour = LINES[number % len(LINES)]
            axes.bar(x, [mean.value for mean in means], 0.88 * step, color=colour, label=name)
            _whiskers(axes, x, means, INK)
        names = [*called[: count - 1], "all"]
        axes.set_xticks([*range(count - 1), count - 1 + 0.35], names)
        axes.tick_params(axis="x", length=0)
        axes.set(ylim=(0, 1), ylabel="success rate")
        axes.axvline(count - 1.325, color=FAINT, lw=1)
        axes.yaxis.set_major_formatter(lambda value, _: PERCENT(value))
        axes.grid(axis="y")
        drawing.figure.legend(loc="outside upper center", ncols=4, fontsize=9)
    return drawing.svg

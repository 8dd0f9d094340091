"""Charts of trials that several pages show: success of each object, by row, and outcomes."""

import string
from collections.abc import Iterable, Mapping, Sequence

import matplotlib
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.patches import Rectangle

from egad.bench.stats import Mean, Rate, TrialGrid, by_object, trial_grid
from egad.evalset import SelectEval, cell_of_label, in_grid, label_at
from egad.report.axes import USUAL, AxisPair
from egad.report.colors import FAINT, INK, SOFT, ink_on, line_color
from egad.report.drawing import new_figure, show_percent
from egad.report.page import DASH
from egad.tables.outcomes import CHARTED

GAP = 0.35
MAX_BARS = 30


def trial_heat_map(
    grid: TrialGrid, rows: int, columns: int, present: set[str], axis_names: AxisPair = USUAL
) -> str:
    """SVG of success rates by cell, as in the paper; labels that are not `present` are hatched."""
    with new_figure(0.8 + 0.62 * (columns + 1.62), 0.6 + 0.62 * (rows + 1.37)) as drawing:
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


def rate_color(value: float) -> str:
    """The blue of a success rate, as `#rrggbb`: the higher, the darker."""
    return to_hex(matplotlib.colormaps["Blues"](0.06 + 0.84 * value))


def _heat_cell(
    axes: Axes, x: float, y: float, rate: Rate | None, present: bool, width: float = 1
) -> None:
    margin = x != int(x) or y != int(y)
    tried = rate is not None and rate.attempts > 0
    color = rate_color(rate.value) if rate is not None and tried else "#ffffff"
    box = Rectangle((x + 0.02, y + 0.02), width - 0.04, 0.96, facecolor=color, lw=0)
    if not tried:
        box.set(edgecolor=FAINT, lw=0.8, hatch=None if present else "////")
    axes.add_patch(box)
    ink = ink_on(color)
    middle = x + width / 2
    if not tried or rate is None:
        axes.text(middle, y + 0.5, DASH if present else "", ha="center", va="center", color=SOFT)
        return
    low, high = (round(100 * end) for end in rate.interval)
    counts = [] if margin else [f"{rate.successes}/{rate.attempts}"]
    below = [*counts, f"{low}{DASH}{high}"]
    top = 0.5 + 0.12 * len(below)
    weight = "bold" if margin else "normal"
    text = f"{rate.value * 100:.0f}"
    axes.text(middle, y + top, text, ha="center", va="center", color=ink, weight=weight, size=11)
    for line, small in enumerate(below, 1):
        height = y + top - 0.1 - 0.21 * line
        axes.text(middle, height, small, ha="center", va="center", color=ink, size=6.5)


def _heat_axes(axes: Axes, rows: int, columns: int, names: AxisPair) -> None:
    axes.set(xlim=(-0.02, columns + GAP + 1.27), ylim=(-1 - GAP - 0.02, rows + 0.02))
    axes.set_aspect("equal")
    axes.set_xticks(
        [*(np.arange(columns) + 0.5), columns + GAP + 0.625], [*map(str, range(columns)), "mean"]
    )
    axes.set_yticks(
        [-0.5 - GAP, *(np.arange(rows) + 0.5)], ["mean", *string.ascii_uppercase[:rows]]
    )
    axes.tick_params(length=0)
    axes.spines[:].set_visible(False)
    axes.set_xlabel(names.across.label)
    axes.set_ylabel(names.upwards.label)


def rate_bars(
    rates: Mapping[str, Sequence[Mean]], groups: Sequence[str] = string.ascii_uppercase
) -> str:
    """SVG of success rates by row of the evaluation set, then over all, with intervals of 95 %."""
    count = max(len(each) for each in rates.values())
    with new_figure(8.6, 3.2) as drawing:
        axes = drawing.figure.add_subplot()
        step = 0.7 / len(rates)
        for number, (name, means) in enumerate(rates.items()):
            x = np.arange(count) + (number - (len(rates) - 1) / 2) * step
            x[-1] += 0.35
            heights = [mean.value for mean in means]
            axes.bar(x, heights, 0.88 * step, color=line_color(number), label=name)
            draw_intervals(axes, x, means, INK)
        names = [*groups[: count - 1], "all"]
        axes.set_xticks([*range(count - 1), count - 1 + 0.35], names)
        axes.tick_params(axis="x", length=0)
        axes.set(ylim=(0, 1), ylabel="success rate")
        axes.axvline(count - 1.325, color=FAINT, lw=1)
        show_percent(axes.yaxis)
        axes.grid(axis="y")
        drawing.figure.legend(loc="outside upper center", ncols=4, fontsize=9)
    return drawing.svg


def draw_intervals(axes: Axes, x: Iterable[float], means: Sequence[Mean], color: str) -> None:
    """Draw vertical lines from the lower to the upper end of rates; none where unknown."""
    for at, mean in zip(x, means, strict=True):
        low, high = mean.interval
        if (low, high) != (0.0, 1.0):
            axes.vlines(at, low, high, color=color, lw=1)


def draw_rates(
    axes: Axes, x: Sequence[float], rates: Sequence[Rate], color: str, name: str = ""
) -> None:
    """Draw a line through rates, with the interval of each."""
    axes.vlines(x, *zip(*(rate.interval for rate in rates), strict=True), color=color, lw=1)
    axes.plot(x, [rate.value for rate in rates], "o-", color=color, ms=4.5, lw=1.4, label=name)


def outcome_counts(trials: pd.DataFrame) -> dict[str, int]:
    """Number of attempts by outcome: success first, then the failures, most frequent first."""
    counts = trials["outcome"].value_counts().to_dict()
    order = sorted(counts, key=lambda name: (name != "success", -counts[name], name))
    return {str(name): int(counts[name]) for name in order}


def outcome_chart(trials: Mapping[str, pd.DataFrame]) -> str:
    """SVG of the outcomes of attempts, a bar for each named `tables.evaluation.TRIALS`."""
    with new_figure(8.6, 0.75 + 0.42 * len(trials)) as drawing:
        axes = drawing.figure.add_subplot()
        counts = {name: outcome_counts(table) for name, table in trials.items()}
        for number, row in enumerate(counts.values()):
            _outcome_bar(axes, -number, row)
        axes.set_yticks([-number for number in range(len(counts))], list(counts))
        axes.tick_params(axis="y", length=0)
        axes.set(xlim=(0, 1), ylim=(-len(counts) + 0.45, 0.55))
        show_percent(axes.xaxis)
        axes.spines[["left"]].set_visible(False)
        used = [each for each in CHARTED if any(each.value in row for row in counts.values())]
        handles = [Rectangle((0, 0), 1, 1, facecolor=each.color) for each in used]
        names = [each.value.replace("_", " ") for each in used]
        drawing.figure.legend(handles, names, loc="outside upper center", ncols=7, fontsize=9)
    return drawing.svg


def trial_chart(trials: pd.DataFrame) -> str:
    """SVG of attempts: a heat map if labels are of a set; else outcomes, `MAX_BARS` objects."""
    objects = by_object(trials)
    names = [str(name) for name in objects.index]
    if len(names) > 1 and in_grid(names):
        rows, columns = (1 + max(each) for each in zip(*map(cell_of_label, names), strict=True))
        if rows <= SelectEval().rows and columns <= SelectEval().columns:
            return trial_heat_map(trial_grid(trials, rows, columns), rows, columns, set(names))
    rates = (objects["successes"] / objects["attempts"]).to_numpy()
    lowest = np.sort(np.argsort(rates, kind="stable")[:MAX_BARS])
    everything = f"all {len(names)} objects"
    if len(names) > MAX_BARS:
        everything += f"\n(below: the lowest {MAX_BARS})"
    tables = {everything: trials} if len(names) > 1 else {}
    tables |= {names[index]: trials[trials["label"] == names[index]] for index in lowest}
    return outcome_chart(tables)


def _outcome_bar(axes: Axes, y: float, counts: Mapping[str, int]) -> None:
    total, start = sum(counts.values()), 0.0
    for outcome in CHARTED:
        count = counts.get(outcome.value, 0)
        share = count / total
        axes.barh(y, share, left=start, height=0.62, color=outcome.color, edgecolor="white", lw=0.6)
        if share > 0.03:
            ink = "white" if outcome.dark else INK
            middle = start + share / 2
            axes.text(middle, y, str(count), ha="center", va="center", color=ink, size=9)
        start += share

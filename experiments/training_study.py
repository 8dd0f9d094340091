"""Figures and tables of docs/training-study.md.

Usage: `python experiments/training_study.py results.parquet`.
"""

import string
import sys
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle

from egad._util.files import write_text
from egad.evalset import cell_of_label
from egad.report.colors import ink_on
from egad.report.drawing import new_figure
from egad.report.page import p_value
from egad.report.training import success_chart
from egad.report.trial_charts import OUTCOMES, outcome_counts, rate_color
from egad.stats import (
    Mean,
    Rate,
    TestAttempts,
    TrialGrid,
    by_set,
    by_test,
    references,
    seed_variance,
    set_pairs,
    trial_grid,
)
from egad.tables import parquet
from egad.tables.grasping import SCALES
from egad.tables.objects import OBJECTS
from egad.tables.training import COMPARED

DOCS = Path(__file__).parents[1] / "docs"
ACROSS = 5  # panels
SIDES = [0.0, 0.02, 0.045, np.inf]  # metres
SIZES = ["to 20 mm", "20 to 45 mm", "above 45 mm"]


def main(path: Path) -> None:
    """Write the figures beside this file and print the tables."""
    tests = by_test(parquet.read(path, COMPARED))
    write_text(DOCS / "training-study.svg", success_chart(tests))
    for name, tried in tests.items():
        grids = grids_of(tried)
        write_text(DOCS / f"training-study-{name}.svg", maps(grids))
        tell(name, tried)
        compare(tried)
        of_trainings(tried)
        along(name, grids)
        ends(name, tried)
        by_size(name, tried, shortest(path.parents[1] / name))


def everyone(tried: TestAttempts) -> dict[str, pd.DataFrame]:
    """Attempts of the networks of each set, and of each other detector."""
    return by_set(tried.rows) | references(tried.rows)


def grids_of(tried: TestAttempts) -> dict[str, TrialGrid]:
    """Success of each object by its place in the evaluation set, the same places for all."""
    places = [cell_of_label(label) for label in tried.rows["label"].unique()]
    rows, columns = (1 + max(each) for each in zip(*places, strict=True))
    return {key: trial_grid(own, rows, columns) for key, own in everyone(tried).items()}


def maps(grids: Mapping[str, TrialGrid]) -> str:
    """Success of each object, a panel a set, as SVG."""
    down = -(-len(grids) // ACROSS)
    with new_figure(2.4 * ACROSS, 2.6 * down) as drawing:
        panels = list(drawing.figure.subplots(down, ACROSS, squeeze=False).flat)
        for axes, (name, grid) in zip(panels, grids.items(), strict=False):
            panel(axes, grid)
            axes.set_title(f"{name}, {grid.overall.value:.0%}", fontsize=10)
        for axes in panels[len(grids) :]:
            axes.remove()
    return drawing.svg


def panel(axes: Axes, grid: TrialGrid) -> None:
    """One of them: one square per object, percent; the easiest row is at the bottom."""
    for (row, column), rate in grid.cells.items():
        color = rate_color(rate.value)
        box = Rectangle((column - 0.48, row - 0.48), 0.96, 0.96, facecolor=color, lw=0)
        axes.add_patch(box)
        text, ink = f"{100 * rate.value:.0f}", ink_on(color)
        axes.text(column, row, text, ha="center", va="center", fontsize=7, color=ink)
    rows, columns = len(grid.rows), len(grid.columns)
    axes.set(xlim=(-0.5, columns - 0.5), ylim=(-0.5, rows - 0.5), aspect="equal")
    axes.set_xticks(range(columns))
    axes.set_yticks(range(rows), list(string.ascii_uppercase[:rows]))
    axes.tick_params(length=0, labelsize=8)
    axes.spines[:].set_visible(False)


def tell(test: str, tried: TestAttempts) -> None:
    """Print the success of all sets in a test."""
    print(f"\n| success on {test}, % | all networks | each |\n| --- | --- | --- |")
    for name, found in tried.sets.items():
        each = ", ".join(f"{100 * one.value:.0f}" for one in found.each.values())
        print(f"| `{name}` | {text(found.pooled)} | {each} |")
    for name, rate in tried.references.items():
        print(f"| {name} | {text(rate)} | |")


def compare(tried: TestAttempts) -> None:
    """Print every pair of sets."""
    print("\n| pair | points | each | began alike | p | p, Holm |\n" + "| --- " * 6 + "|")
    for pair in set_pairs(by_set(tried.rows)):
        gain, low, high = map(points, (pair.result.difference, *pair.result.interval))
        each = ", ".join(map(points, pair.each))
        alike = f"{pair.result.alike} of {pair.result.attempts}"
        numbers = f"{each} | {alike} | {p_value(pair.result.p_objects)} | {p_value(pair.p_holm)}"
        difference = f"{gain} ({low} to {high})"
        print(f"| `{pair.first}` against `{pair.second}` | {difference} | {numbers} |")


def of_trainings(tried: TestAttempts) -> None:
    """Print whether sets differ by more than single trainings do."""
    if found := seed_variance(tried.sets):
        spread, p = 100 * found.spread, p_value(found.p)
        print(f"\nwithin sets: standard deviation {spread:.1f} points; F {found.f:.1f}, p {p}")


def along(test: str, grids: Mapping[str, TrialGrid]) -> None:
    """Print the success of whole rows, then of whole columns."""
    one = next(iter(grids.values()))
    letters = list(string.ascii_uppercase[: len(one.rows)])
    digits = [str(column) for column in range(len(one.columns))]
    share(f"by row on {test}, %", letters, {key: grid.rows for key, grid in grids.items()})
    share(f"by column on {test}, %", digits, {key: grid.columns for key, grid in grids.items()})


def share(title: str, places: list[str], rates: Mapping[str, list[Mean]]) -> None:
    """Print rates of places, one line per set."""
    print(f"\n| {title} | {' | '.join(places)} |\n" + "| --- " * (len(places) + 1) + "|")
    for name, found in rates.items():
        cells = (f"{100 * rate.value:.0f}" if rate.attempts else "" for rate in found)
        print(f"| `{name}` | {' | '.join(cells)} |")


def ends(test: str, tried: TestAttempts) -> None:
    """Print how attempts ended."""
    counts = {name: outcome_counts(rows) for name, rows in everyone(tried).items()}
    kinds = [kind for kind in OUTCOMES if any(kind in found for found in counts.values())]
    print(f"\n| attempts on {test}, % | {' | '.join(kind.replace('_', ' ') for kind in kinds)} |")
    print("| --- " * (len(kinds) + 1) + "|")
    for name, found in counts.items():
        parts = (f"{100 * found.get(kind, 0) / sum(found.values()):.1f}" for kind in kinds)
        print(f"| `{name}` | {' | '.join(parts)} |")


def shortest(dataset: Path) -> pd.Series:
    """The shortest side of each object of a dataset as it is tried, metres, by id."""
    ids = parquet.read(dataset / "objects.parquet", OBJECTS).set_index("label")["id"]
    (scales,) = (dataset / "rescaled").glob("*/scales.parquet")
    scaled = parquet.read(scales, SCALES)
    return pd.Series(scaled["after_1"].to_numpy(), ids[scaled["label"]])


def by_size(test: str, tried: TestAttempts, sides: pd.Series) -> None:
    """Print success by the shortest side of the objects, and of how many of the dataset it is."""
    parts = pd.cut(sides, SIDES, labels=SIZES)
    print(f"\n| by shortest side on {test}, % | {' | '.join(SIZES)} |\n" + "| --- " * 4 + "|")
    there = [f"{100 * (parts == size).mean():.0f}" for size in SIZES]
    print(f"| objects of the dataset | {' | '.join(there)} |")
    for name, rows in everyone(tried).items():
        rates = rows.groupby(rows["id"].map(parts), observed=True)["success"].mean()
        cells = (f"{100 * rates[size]:.0f}" if size in rates else "" for size in SIZES)
        print(f"| `{name}` | {' | '.join(cells)} |")


def points(gain: float) -> str:
    """A difference of rates, percentage points."""
    return str(round(100 * gain))


def text(rate: Rate) -> str:
    """A rate with its interval, percent."""
    low, high = (100 * end for end in rate.interval)
    return f"{100 * rate.value:.0f} ({low:.0f} to {high:.0f})"


if __name__ == "__main__":
    main(Path(sys.argv[1]))

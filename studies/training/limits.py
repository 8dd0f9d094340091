"""What limits the networks of README.md: `python limits.py RESULTS`.

Prints how the attempts of training.parquet ended, and for the sets of the
pre-registered comparisons and the references: success by row, column and width of the objects; the
objects at which the first set fails most often; and success with and without a labelled grasp
within reach. Draws studies/training/training-labels.svg, the success at each object. RESULTS is the
folder `results` of the study, for the sizes of the objects.
"""

import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle
from study import read_study
from study_page import NOISE_TITLES, attempts_by_set, by_part
from study_results import sides_of

from egad._util.files import write_text
from egad._util.markdown import table
from egad.evalset import cell_of_label
from egad.report.colors import ink_on
from egad.report.drawing import new_figure
from egad.report.trial_charts import outcome_counts, rate_color
from egad.tables.outcomes import CHARTED

CONFIG = Path(__file__).with_name("study.yaml")
FOLDER = Path(__file__).parent
WORST = 12
ACROSS = 3
LABELS = "labels"
DROP = ["label", "attempt"]
Attempts = dict[str, pd.DataFrame]


def main(results: Path, config: Path = CONFIG, docs: Path = FOLDER) -> None:
    """Print the tables and draw the figure."""
    study = read_study(config)
    plan = study.plan
    names = [*(name for pair in plan.comparisons for name in pair), *plan.references]
    trials = pd.read_parquet(docs / "training.parquet")
    rates = {}
    for (test, noise), rows in trials.groupby(["test", "noise"], sort=False):
        found = attempts_by_set(rows)
        title = f"{test}, {NOISE_TITLES[str(noise)]}"
        print_outcomes(title, found)
        shown = {name: found[name] for name in dict.fromkeys(names) if name in found}
        sides = sides_of(results / str(test), study.gripper)
        print_parts(title, shown, {label: each[0] for label, each in sides.items()})
        by_object = {name: by_label(own) for name, own in shown.items()}
        print_objects(title, by_object, sides)
        if LABELS in found:
            print_reachable(title, shown, found[LABELS])
        if noise == "none":
            rates[str(test)] = by_object
    write_text(docs / "training-labels.svg", label_maps(rates))


def print_outcomes(title: str, found: Attempts) -> None:
    """How attempts at single objects ended, percent."""
    counts = {name: outcome_counts(each) for name, each in found.items()}
    kinds = [kind.value for kind in CHARTED if any(kind.value in each for each in counts.values())]
    rows = [
        [f"`{name}`", *(f"{100 * each.get(kind, 0) / sum(each.values()):.1f}" for kind in kinds)]
        for name, each in counts.items()
    ]
    print_table([title, *(kind.replace("_", " ") for kind in kinds)], rows)


def print_parts(title: str, found: Attempts, widths: Mapping[str, float]) -> None:
    """Success by row, column and width, percent."""
    parts = {name: by_part(own, widths) for name, own in found.items()}
    rows = [
        [part, *(f"{100 * each[part]:.0f}" for each in parts.values())]
        for part in next(iter(parts.values()))
    ]
    print_table([title, *(f"`{name}`" for name in parts)], rows)


def print_objects(
    title: str,
    rates: Mapping[str, Mapping[str, float]],
    sides: Mapping[str, Sequence[float]],
) -> None:
    """The objects that the first set loses most often.

    Prints their size in millimetres, the cumulative share of its failures, and success.
    """
    lost = 1 - pd.Series(next(iter(rates.values())))
    shares = (lost / lost.sum()).sort_values(ascending=False, kind="stable").cumsum()
    rows = [
        [
            str(label),
            " x ".join(f"{1000 * side:.0f}" for side in sides[str(label)]),
            f"{100 * share:.0f}",
            *(f"{100 * each[str(label)]:.0f}" for each in rates.values()),
        ]
        for label, share in shares.head(WORST).items()
    ]
    rest = shares.index[WORST:]
    success = [f"{100 * pd.Series(each)[rest].mean():.0f}" for each in rates.values()]
    rows.append([f"the other {len(rest)}", "", "100", *success])
    print_table([title, "size, mm", "failures up to here", *(f"`{name}`" for name in rates)], rows)


def print_reachable(title: str, found: Attempts, labels: pd.DataFrame) -> None:
    """Success where a labelled grasp can be reached from above and where none can, percent.

    Args:
        title: Title of the test.
        found: Attempts of sets and detectors.
        labels: Those of the detector `labels`, from the same poses.
    """
    none = labels.set_index(DROP)["outcome"] == "no_grasp"
    rows = []
    for head, drops in [("labelled grasp", none[~none].index), ("none", none[none].index)]:
        rates = (own.set_index(DROP)["success"] for own in found.values())
        cells = [f"{100 * rate[rate.index.isin(drops)].mean():.0f}" for rate in rates]
        rows.append([head, f"{100 * len(drops) / len(none):.0f}", *cells])
    print_table([title, "attempts", *(f"`{name}`" for name in found)], rows)


def print_table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    """A table of Markdown after an empty line."""
    print("\n" + table(heads, rows), end="")


def by_label(rows: pd.DataFrame) -> dict[str, float]:
    """Success at each object."""
    return {str(key): float(rate) for key, rate in rows.groupby("label")["success"].mean().items()}


def label_maps(tests: Mapping[str, Mapping[str, Mapping[str, float]]]) -> str:
    """Success at each object in percent, SVG text: a map for each test and set.

    Args:
        tests: Success by label, by set, by title of the test.
    """
    maps = [
        (f"{name}: {title}", each) for title, sets in tests.items() for name, each in sets.items()
    ]
    down = -(-len(maps) // ACROSS)
    with new_figure(2.6 * ACROSS, 2.75 * down) as drawing:
        panels = drawing.figure.subplots(down, ACROSS, squeeze=False).flat
        for axes, (title, rates) in zip(panels, maps, strict=False):
            draw_map(axes, rates)
            axes.set_title(title, fontsize=9)
        for axes in panels[len(maps) :]:
            axes.remove()
    return drawing.svg


def draw_map(axes: Axes, rates: Mapping[str, float]) -> None:
    """A map of the evaluation set."""
    for label, rate in rates.items():
        row, column = cell_of_label(label)
        color = rate_color(rate)
        axes.add_patch(Rectangle((column + 0.02, row + 0.02), 0.96, 0.96, facecolor=color, lw=0))
        text: dict[str, Any] = {
            "ha": "center",
            "va": "center",
            "fontsize": 7,
            "color": ink_on(color),
        }
        axes.text(column + 0.5, row + 0.5, f"{100 * rate:.0f}", **text)
    ticks = [each + 0.5 for each in range(7)]
    axes.set(xlim=(0, 7), ylim=(0, 7), aspect="equal")
    axes.set_xticks(ticks, list("0123456"))
    axes.set_yticks(ticks, list("ABCDEFG"))
    axes.tick_params(length=0, labelsize=8)
    axes.spines[:].set_visible(False)


if __name__ == "__main__":
    main(Path(sys.argv[1]))

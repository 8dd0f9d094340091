"""The section Evolution: coverage over evaluations, and how elites moved when re-evaluated."""

from collections.abc import Mapping
from dataclasses import dataclass

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from egad.measures import MeasureSpace, coverage, difficulty_cells
from egad.report.colors import line_color
from egad.report.drawing import new_figure, show_percent
from egad.report.page import svg_uri

THIN = "\N{NARROW NO-BREAK SPACE}"


@dataclass(frozen=True)
class ReEvaluation:
    """How the objects of an archive moved when their graspability was measured again."""

    stayed: float  # fraction of the objects that stayed in their cell
    by_one: float  # fraction that moved by one cell
    by_more: float  # fraction that moved further
    mean: float  # mean move towards hard, cells
    before: float  # coverage by the first graspability
    after: float  # coverage by the second one


@dataclass(frozen=True)
class EvolutionView:
    """The evolution of a dataset; the curves are an address, empty if there are none."""

    curves: str
    re_evaluation: ReEvaluation | None


def evolution_view(
    objects: pd.DataFrame, history: pd.DataFrame | None, space: MeasureSpace
) -> EvolutionView | None:
    """What the section shows of `OBJECTS`; None if they were not evolved."""
    moves = re_evaluation(objects, space)
    if history is None:
        return None if moves is None else EvolutionView("", moves)
    return EvolutionView(svg_uri(coverage_curves({"": history})), moves)


def re_evaluation(objects: pd.DataFrame, space: MeasureSpace) -> ReEvaluation | None:
    """How objects moved when graspability was measured again; None if none was selected by it."""
    elites = objects.dropna(subset=["archive_graspability"])
    if elites.empty:
        return None
    before = difficulty_cells(elites["archive_graspability"], space)
    moves = elites["difficulty_cell"].to_numpy() - before
    return ReEvaluation(
        stayed=float((moves == 0).mean()),
        by_one=float((abs(moves) == 1).mean()),
        by_more=float((abs(moves) > 1).mean()),
        mean=float(moves.mean()),
        before=coverage(elites.assign(difficulty_cell=before), space),
        after=coverage(elites, space),
    )


def coverage_history(history: pd.DataFrame) -> pd.DataFrame:
    """Offspring, coverage, filled_cells, qd_score so far, over all islands; best island."""
    ordered = history.sort_values(["epoch", "step", "coverage"])
    steps = ordered.groupby(["epoch", "step"])
    best = steps.tail(1).set_index(["epoch", "step"])
    return best.assign(offspring=steps["offspring"].sum().cumsum()).reset_index()[
        ["offspring", "coverage", "filled_cells", "qd_score"]
    ]


def coverage_curves(histories: Mapping[str, pd.DataFrame]) -> str:
    """SVG of coverage, filled cells and QD-score over evaluations, from HISTORY tables by run."""
    runs = {name: coverage_history(history) for name, history in histories.items()}
    panels = {"coverage": "coverage", "filled_cells": "filled cells", "qd_score": "QD-score"}
    with new_figure(9.6, 2.9) as drawing:
        grid = drawing.figure.subplots(1, 3)
        for axes, (column, title) in zip(grid, panels.items(), strict=True):
            for number, (name, run) in enumerate(runs.items()):
                known = run.dropna(subset=[column])
                color = line_color(number)
                axes.plot(known["offspring"], known[column], color=color, lw=1.6, label=name)
            _finish(axes, title, share=column != "qd_score")
        if len(runs) > 1:
            handles, names = grid[0].get_legend_handles_labels()
            drawing.figure.legend(handles, names, loc="outside upper center", ncols=4)
    return drawing.svg


def _finish(axes: Axes, title: str, *, share: bool) -> None:
    axes.set(xlabel="evaluations", title=title, xlim=(0, None))
    axes.set_ylim(0, 1 if share else None)
    axes.title.set_fontsize(10)
    axes.xaxis.set_major_locator(MaxNLocator(4, integer=True))
    axes.xaxis.set_major_formatter(lambda value, _: f"{value:,.0f}".replace(",", THIN))
    if share:
        show_percent(axes.yaxis)
    axes.grid(axis="y")

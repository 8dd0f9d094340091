"""The section Comparison: datasets beside the published ones; and a small map of each."""

import math
import string
from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import PatchCollection
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from numpy.typing import NDArray

from egad.measures import Attainable, MeasureSpace, coverage
from egad.report.axes import USUAL, AxisPair
from egad.report.colors import COLOR_MAP, FAINT, SOFT
from egad.report.drawing import new_figure
from egad.report.page import Section, section_of

COLUMNS = 3
SIDE = 2.6
TICK = 6
CELL = ["complexity_cell", "difficulty_cell"]
PUBLISHED = pd.DataFrame(
    [
        ("EGAD, 2020", 2331, 0.93, 0.07, 0.27, 0.19),
        ("YCB", 78, 0.03, 0.11, 0.65, 0.19),
        ("Dex-Net 2.0", 1497, 0.37, 0.03, 0.26, 0.11),
    ],
    columns=["dataset", "objects", "coverage", "diversity_min", "diversity_max", "diversity_mean"],
)
"""EGAD (Morrison, Corke, Leitner 2020), Table III."""


def section(comparison: pd.DataFrame, space: MeasureSpace, limit: Attainable) -> Section:
    """All datasets of a run, `tables.objects.COMPARISON`, beside the published ones."""
    return section_of(
        "comparison.html.j2",
        "Comparison",
        comparison=comparison.to_dict("records"),
        published=PUBLISHED.to_dict("records"),
        space=space,
        limit=limit,
    )


def comparison_text(comparison: pd.DataFrame) -> str:
    """`tables.objects.COMPARISON` for a terminal, the published ones beneath (EGAD, Table III)."""
    titles = ("objects", "coverage", "attainable", "diversity: min", "max", "mean")
    ours = [_comparison_line(row, 1) for row in comparison.to_dict("records")]
    theirs = [_comparison_line(row, 0) for row in PUBLISHED.to_dict("records")]
    return "\n".join([_columns("dataset", *titles), *ours, "published", *theirs])


def _comparison_line(row: Mapping[Any, Any], digits: int) -> str:
    values = [row[f"diversity_{name}"] for name in ("min", "max", "mean")]
    least, most, mean = ("-" if pd.isna(value) else f"{value:.2f}" for value in values)
    covered = f"{100 * row['coverage']:.{digits}f} %"
    of_attainable = row.get("attainable_coverage")
    part = "-" if of_attainable is None else f"{100 * of_attainable:.{digits}f} %"
    return _columns(row["dataset"], str(row["objects"]), covered, part, least, most, mean)


def _columns(name: str, objects: str, covered: str, part: str, *diversity: str) -> str:
    least, most, mean = diversity
    return f"{name:20}{objects:>9}{covered:>10}{part:>12}{least:>16}{most:>6}{mean:>6}"


def dataset_maps(
    datasets: Mapping[str, pd.DataFrame],
    space: MeasureSpace,
    names: AxisPair = USUAL,
    unattainable: int = 0,
) -> str:
    """SVG of objects of each dataset by cell, on the same axes; `unattainable` rows are hatched."""
    counts = {name: objects.groupby(CELL).size() for name, objects in datasets.items()}
    most = max([2, *(int(count.max()) for count in counts.values() if len(count))])
    rows = math.ceil(len(datasets) / COLUMNS)
    columns = math.ceil(len(datasets) / rows)
    with new_figure(SIDE * columns + 1.1, (SIDE + 0.4) * rows + 0.4) as drawing:
        grid = drawing.figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
        panels = grid.ravel()
        for axes, (name, objects) in zip(panels, datasets.items(), strict=False):
            _map(axes, counts[name], most, space.cells)
            _hatch(axes, unattainable, space.cells)
            covered = f"{100 * coverage(objects, space):.1f} %"
            axes.set_title(f"{name}\n{len(objects)} objects, coverage {covered}", size=10)
        for axes in panels[len(datasets) - columns : len(datasets)]:
            axes.tick_params(labelbottom=True)
        for axes in panels[len(datasets) :]:
            axes.set_axis_off()
        drawing.figure.supxlabel(names.across.label, size=10)
        drawing.figure.supylabel(names.upwards.label, size=10)
        _color_bar(drawing.figure, grid, most)
    return drawing.svg


def _color_bar(figure: Figure, grid: NDArray[np.object_], most: int) -> None:
    colors = ScalarMappable(LogNorm(1, most), COLOR_MAP)
    bar = figure.colorbar(colors, ax=grid, label="objects in a cell", shrink=0.8, aspect=25)
    ticks = [2**power for power in range(most.bit_length())]
    bar.set_ticks(ticks, labels=list(map(str, ticks)))
    bar.ax.minorticks_off()
    bar.outline.set_visible(False)


def _hatch(axes: Axes, rows: int, cells: int) -> None:
    if rows:
        box = Rectangle((0, 0), cells, rows, fill=False, edgecolor=SOFT, hatch="/////", linewidth=0)
        axes.add_patch(box)


def _map(axes: Axes, counts: "pd.Series[int]", most: int, cells: int) -> None:
    """A square for each filled cell, on a frame of all cells."""
    boxes = [Rectangle((column + 0.04, row + 0.04), 0.92, 0.92) for column, row in counts.index]
    squares = PatchCollection(boxes, cmap=COLOR_MAP, norm=LogNorm(1, most), linewidths=0)
    squares.set_array(counts.to_numpy())
    axes.add_collection(squares)
    ticks = np.arange(0, cells, TICK)
    axes.set(xlim=(0, cells), ylim=(0, cells), aspect="equal")
    axes.set_xticks(ticks + 0.5, [f"{tick:02d}" for tick in ticks])
    axes.set_yticks(ticks + 0.5, [string.ascii_uppercase[tick] for tick in ticks])
    axes.tick_params(length=0, labelsize=8)
    axes.spines[:].set_visible(True)
    axes.spines[:].set_color(FAINT)

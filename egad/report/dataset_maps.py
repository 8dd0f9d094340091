"""Small maps of datasets, side by side on the same axes and colour scale, as SVG text."""

import math
import string
from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import PatchCollection
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from numpy.typing import NDArray

from egad.measures.grid import coverage
from egad.measures.parameters import Space
from egad.report.axes import USUAL, AxisPair
from egad.report.style import FAINT, drawn

COLUMNS = 3
SIDE = 2.6
TICK = 6
MAP = "viridis"
CELL = ["complexity_cell", "difficulty_cell"]


def dataset_maps(
    datasets: Mapping[str, pd.DataFrame], space: Space, names: AxisPair = USUAL
) -> str:
    """How many objects of each dataset lie in each cell, simple to complex and easy to hard.

    Args:
        datasets: Columns of `tables.objects.OBJECTS`, by name.
        space: The cells.
        names: What is written along the axes.

    Returns:
        SVG text.
    """
    counts = {name: objects.groupby(CELL).size() for name, objects in datasets.items()}
    most = max([2, *(int(count.max()) for count in counts.values() if len(count))])
    columns = min(COLUMNS, len(datasets))
    rows = math.ceil(len(datasets) / columns)
    with drawn(SIDE * columns + 1.1, (SIDE + 0.4) * rows + 0.4) as drawing:
        grid = drawing.figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
        places = grid.ravel()
        for axes, (name, objects) in zip(places, datasets.items(), strict=False):
            _map(axes, counts[name], most, space.cells)
            filled = f"{100 * coverage(objects, space):.1f} %"
            axes.set_title(f"{name}\n{len(objects)} objects, coverage {filled}", size=10)
        for axes in places[len(datasets) - columns : len(datasets)]:
            axes.tick_params(labelbottom=True)
        for axes in places[len(datasets) :]:
            axes.set_axis_off()
        drawing.figure.supxlabel(names.across.label, size=10)
        drawing.figure.supylabel(names.upwards.label, size=10)
        _colour_bar(drawing.figure, grid, most)
    return drawing.svg


def _colour_bar(figure: Figure, grid: NDArray[np.object_], most: int) -> None:
    colours = ScalarMappable(LogNorm(1, most), MAP)
    bar = figure.colorbar(colours, ax=grid, label="objects in a cell", shrink=0.8, aspect=25)
    ticks = [2**power for power in range(most.bit_length())]
    bar.set_ticks(ticks, labels=list(map(str, ticks)))
    bar.ax.minorticks_off()
    bar.outline.set_visible(False)


def _map(axes: Axes, counts: "pd.Series[int]", most: int, cells: int) -> None:
    """A square for each filled cell, on a frame of all cells."""
    boxes = [Rectangle((column + 0.04, row + 0.04), 0.92, 0.92) for column, row in counts.index]
    squares = PatchCollection(boxes, cmap=MAP, norm=LogNorm(1, most), linewidths=0)
    squares.set_array(counts.to_numpy())
    axes.add_collection(squares)
    ticks = np.arange(0, cells, TICK)
    axes.set(xlim=(0, cells), ylim=(0, cells), aspect="equal")
    axes.set_xticks(ticks + 0.5, [f"{tick:02d}" for tick in ticks])
    axes.set_yticks(ticks + 0.5, [string.ascii_uppercase[tick] for tick in ticks])
    axes.tick_params(length=0, labelsize=8)
    axes.spines[:].set_visible(True)
    axes.spines[:].set_color(FAINT)

"""A page that shows where objects lie in the space of a dataset, and their nearest neighbors."""

import string
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import matplotlib
import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from egad.measures import MeasureSpace, cell_name
from egad.report.axes import USUAL, AxisPair
from egad.report.colors import INK
from egad.report.drawing import new_figure
from egad.report.page import data_uri, render_template, svg_uri

MARK = "#d55e00"
FEW = 3


@dataclass(frozen=True)
class Neighbor:
    """An object of the dataset that is similar; its distance is 1 - similarity, its picture PNG."""

    label: str
    distance: float
    picture: bytes


@dataclass(frozen=True)
class Located:
    """An object, `tables.objects.LOCATED`, its PNG, and the most similar objects, nearest first."""

    row: Mapping[str, Any]
    picture: bytes
    neighbors: Sequence[Neighbor]


def page(
    name: str,
    objects: pd.DataFrame,
    located: Sequence[Located],
    reasons: Mapping[str, str],
    space: MeasureSpace,
    axes: AxisPair = USUAL,
) -> str:
    """An HTML page by itself, with objects in the space of a dataset, `reasons` for the others."""
    cells = [(each.row["complexity_cell"], each.row["difficulty_cell"]) for each in located]
    return render_template(
        "locations.html.j2",
        name=name,
        objects=len(objects),
        located=[_view(each) for each in located],
        reasons=reasons,
        chart=svg_uri(location_map(objects, cells, space, axes)),
        space=space,
        axes=axes,
    )


def _view(item: Located) -> dict[str, Any]:
    row = item.row
    return {
        **row,
        "cell": cell_name(row["complexity_cell"], row["difficulty_cell"]),
        "picture": data_uri(item.picture),
        "neighbors": [
            (each.label, each.distance, data_uri(each.picture)) for each in item.neighbors
        ],
    }


def location_map(
    objects: pd.DataFrame,
    marks: Sequence[tuple[int, int]],
    space: MeasureSpace,
    names: AxisPair = USUAL,
) -> str:
    """SVG of the filled cells of a dataset, with cells marked by numbers from 1."""
    counts = np.zeros((space.cells, space.cells))
    np.add.at(counts, (objects["difficulty_cell"], objects["complexity_cell"]), 1)
    shades = matplotlib.colormaps["Greys"](0.12 + 0.4 * counts / max(counts.max(), 1))
    shades[counts == 0] = 1
    with new_figure(6.4, 6.4) as drawing:
        axes = drawing.figure.add_subplot()
        axes.imshow(shades, origin="lower")
        _draw_marks(axes, marks)
        ticks = range(0, space.cells, max(1, space.cells // 6))
        axes.set_xticks(list(ticks), [f"{tick:02d}" for tick in ticks])
        axes.set_yticks(list(ticks), [string.ascii_uppercase[tick] for tick in ticks])
        axes.set_xlabel(names.across.label)
        axes.set_ylabel(names.upwards.label)
        axes.spines[:].set_visible(True)
    return drawing.svg


def _draw_marks(axes: Axes, marks: Sequence[tuple[int, int]]) -> None:
    """One mark per cell, with the numbers of all objects in it."""
    numbers_of: dict[tuple[int, int], list[str]] = {}
    for number, cell in enumerate(marks, 1):
        numbers_of.setdefault(cell, []).append(str(number))
    for (column, row), numbers in numbers_of.items():
        axes.plot(column, row, "o", color=MARK, markersize=6, markeredgecolor="white")
        more = f" +{len(numbers) - FEW}" if len(numbers) > FEW else ""
        axes.annotate(
            ", ".join(numbers[:FEW]) + more,
            (column, row),
            xytext=(5, 4),
            textcoords="offset points",
            color=INK,
            fontsize=8,
            weight="bold",
        )

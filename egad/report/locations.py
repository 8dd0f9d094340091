"""A page that shows where objects lie in the space, and what is most like each of them."""

import string
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import matplotlib
import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from egad.measures.grid import cell_name
from egad.measures.parameters import Axes as Own
from egad.measures.parameters import Space
from egad.report.axes import USUAL, AxisPair, axis_pair
from egad.report.environment import environment
from egad.report.maps import data_uri
from egad.report.style import INK, drawn

MARK = "#d55e00"
FEW = 3


@dataclass(frozen=True)
class Neighbour:
    """An object of the dataset that is like the one shown.

    Attributes:
        label: Its label.
        distance: 1 - similarity.
        picture: PNG.
    """

    label: str
    distance: float
    picture: bytes


@dataclass(frozen=True)
class Located:
    """An object and its place.

    Attributes:
        row: Columns of `tables.objects.LOCATED`.
        picture: PNG.
        neighbours: The objects most like it, the nearest first.
    """

    row: Mapping[str, Any]
    picture: bytes
    neighbours: Sequence[Neighbour]


def page(
    name: str,
    objects: pd.DataFrame,
    located: Sequence[Located],
    reasons: Mapping[str, str],
    space: Space,
    own: Own,
) -> str:
    """Show objects in the space of a dataset.

    Args:
        name: The dataset.
        objects: Its objects: columns complexity_cell and difficulty_cell.
        located: What to show.
        reasons: Names of meshes that could not be used, and why.
        space: The cells.
        own: The user's own measures that span them.

    Returns:
        An HTML page that needs no other file.
    """
    marks = [(each.row["complexity_cell"], each.row["difficulty_cell"]) for each in located]
    axes = axis_pair(own)
    chart = data_uri(location_map(objects, marks, space, axes).encode(), "image/svg+xml")
    return (
        environment()
        .get_template("locations.html.j2")
        .render(
            name=name,
            objects=len(objects),
            located=[_view(each) for each in located],
            reasons=reasons,
            chart=chart,
            space=space,
            axes=axes,
            own=own,
        )
    )


def _view(item: Located) -> dict[str, Any]:
    row = item.row
    return {
        **row,
        "cell": cell_name(row["complexity_cell"], row["difficulty_cell"]),
        "picture": data_uri(item.picture),
        "neighbours": [
            (each.label, each.distance, data_uri(each.picture)) for each in item.neighbours
        ],
    }


def location_map(
    objects: pd.DataFrame, marks: Sequence[tuple[int, int]], space: Space, names: AxisPair = USUAL
) -> str:
    """The filled cells of a dataset, with numbered marks on them.

    Args:
        objects: Columns complexity_cell and difficulty_cell.
        marks: Cells along complexity and along difficulty; numbered from 1.
        space: The cells.
        names: What is written along the axes.

    Returns:
        SVG text.
    """
    counts = np.zeros((space.cells, space.cells))
    np.add.at(counts, (objects["difficulty_cell"], objects["complexity_cell"]), 1)
    shades = matplotlib.colormaps["Greys"](0.12 + 0.4 * counts / max(counts.max(), 1))
    shades[counts == 0] = 1
    with drawn(6.4, 6.4) as drawing:
        axes = drawing.figure.add_subplot()
        axes.imshow(shades, origin="lower")
        _mark(axes, marks)
        letters = string.ascii_uppercase[: space.cells]
        step = range(0, space.cells, max(1, space.cells // 6))
        axes.set_xticks(list(step), [str(place) for place in step])
        axes.set_yticks(list(step), [letters[place] for place in step])
        axes.set_xlabel(names.across.label)
        axes.set_ylabel(names.upwards.label)
        axes.spines[:].set_visible(True)
    return drawing.svg


def _mark(axes: Axes, marks: Sequence[tuple[int, int]]) -> None:
    """One mark a cell, with the numbers of all that lie in it."""
    places: dict[tuple[int, int], list[str]] = {}
    for number, place in enumerate(marks, 1):
        places.setdefault(place, []).append(str(number))
    for (column, row), numbers in places.items():
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

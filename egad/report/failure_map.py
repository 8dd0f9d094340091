"""Maps of a search for failures: reference minus detector, and the dataset beside it."""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd

from egad.measures import MeasureSpace, cell_name, complexity_cells, difficulty_cells
from egad.report.archive_map import MARGIN, UNIT, map_values, picture_of
from egad.report.axes import USUAL, AxisPair
from egad.report.page import DASH, counted, render_template

DIFFERENCES = ("difference_mujoco", "difference_pybullet")
DIFFERENCE_STEPS = (0.6, 0.7, 0.8, 0.9)
DIFFERENCE_COLORS = ("#ffeda0", "#fec44f", "#fe9929", "#d95f0e", "#993404")  # ColorBrewer YlOrBr
COUNT_STEPS = (2, 3, 4)
COUNT_COLORS = ("#c6dbef", "#9ecae1", "#4292c6", "#08519c")  # ColorBrewer Blues
NO_FAILURE = "#d5d9df"
AT_LEAST = "\N{GREATER-THAN OR EQUAL TO}"


class MapCell(NamedTuple):
    """What a map shows of a cell."""

    color: str
    title: str  # text shown when the mouse points at it
    picture: str = ""  # address of a picture, or empty
    number: int = 0  # number in the corner; not shown below 2


class LegendEntry(NamedTuple):
    """A color of a map, and what it means."""

    color: str
    text: str


def lowest_difference(table: pd.DataFrame) -> pd.Series:
    """The lowest difference in any engine of each of `tables.failures.FAILURES`."""
    return table[list(DIFFERENCES)].min(axis=1)


def failure_map(
    table: pd.DataFrame, examined: pd.DataFrame, space: MeasureSpace, axes: AxisPair = USUAL
) -> str:
    """SVG map of the highest difference by cell; grey where objects were tried, but none failed."""
    tried = examined[examined["attempts"] > 0]
    cells = {
        name: MapCell(NO_FAILURE, f"{name}: {counted(len(rows), 'object')} tried, no failure")
        for name, rows in _by_cell(tried)
    }
    for name, rows in _by_cell(table.assign(difference=lowest_difference(table))):
        worst = rows.iloc[int(rows["difference"].to_numpy().argmax())]
        text = f"{counted(len(rows), 'failure')}, difference {100 * worst['difference']:.0f} points"
        cells[name] = MapCell(
            _color(worst["difference"], DIFFERENCE_STEPS, DIFFERENCE_COLORS),
            f"{name}: {text}",
            _picture(worst["voxels"]),
            len(rows),
        )
    words = ["< 60", *(f"{a}{DASH}{a + 10}" for a in (60, 70, 80)), f"{AT_LEAST} 90"]
    legend = [LegendEntry(*each) for each in zip(DIFFERENCE_COLORS, words, strict=True)]
    found = len(table[["complexity_cell", "difficulty_cell"]].drop_duplicates())
    where = f"{counted(len(table), 'failure')} in {counted(found, 'cell')}"
    return _draw(
        cells,
        f"Reference minus detector, points: {where}",
        [*legend, LegendEntry(NO_FAILURE, "no failure")],
        space,
        axes,
    )


def dataset_map(objects: pd.DataFrame, space: MeasureSpace, axes: AxisPair) -> str:
    """SVG map of the objects that a search may start from: how many each cell holds."""
    placed = pd.DataFrame(
        {
            "complexity_cell": complexity_cells(objects["complexity"], space),
            "difficulty_cell": difficulty_cells(objects["graspability"], space),
        }
    )
    cells = {
        name: MapCell(
            _color(len(rows), COUNT_STEPS, COUNT_COLORS), f"{name}: {counted(len(rows), 'object')}"
        )
        for name, rows in _by_cell(placed)
    }
    words = ("1", "2", "3", f"{AT_LEAST} 4")
    legend = [LegendEntry(*each) for each in zip(COUNT_COLORS, words, strict=True)]
    title = f"Dataset: {counted(len(objects), 'object')} in {counted(len(cells), 'cell')}"
    return _draw(cells, title, legend, space, axes)


def _draw(
    cells: dict[str, MapCell],
    title: str,
    legend: Sequence[LegendEntry],
    space: MeasureSpace,
    axes: AxisPair,
) -> str:
    return render_template(
        "failure_map.svg.j2",
        **map_values({}, space, axes) | {"cells": cells},
        unit=UNIT,
        title=title,
        legend=legend,
    )


def _by_cell(table: pd.DataFrame) -> Iterable[tuple[str, pd.DataFrame]]:
    cells = zip(table["complexity_cell"], table["difficulty_cell"], strict=True)
    names = np.array([cell_name(column, row) for column, row in cells], dtype=object)
    for name, rows in table.groupby(names):
        yield str(name), rows


def _color(value: float, steps: Sequence[float], colors: Sequence[str]) -> str:
    return colors[sum(value >= step for step in steps)]


def _picture(voxels: bytes) -> str:
    resolution = round((8 * len(voxels)) ** (1 / 3))
    return picture_of(voxels, resolution, 2 * (UNIT - MARGIN))

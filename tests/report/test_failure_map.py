"""Maps of failures: colors, counts and cells."""

import re

import numpy as np
import pandas as pd
import pytest
from partial_tables import fill_columns
from svg_text import texts

from egad.evolution.voxels import pack
from egad.measures import MeasureSpace
from egad.report.axes import USUAL
from egad.report.failure_map import (
    COUNT_COLORS,
    DIFFERENCE_COLORS,
    NO_FAILURE,
    dataset_map,
    failure_map,
    lowest_difference,
)
from egad.tables.failures import EXAMINED, FAILURES

VOXELS = pack(np.ones((25, 25, 25), bool))
SPACE = MeasureSpace(cells=4)


def failures(*rows):
    """From columns, rows and the difference in both engines."""
    names = ("complexity_cell", "difficulty_cell", "difference_mujoco", "difference_pybullet")
    known = [dict(zip(names, row, strict=True)) | {"voxels": VOXELS} for row in rows]
    return fill_columns(FAILURES, known) if rows else pd.DataFrame(columns=FAILURES.names)


def examined(*cells):
    names = ("complexity_cell", "difficulty_cell", "attempts")
    return fill_columns(EXAMINED, [dict(zip(names, cell, strict=True)) for cell in cells])


def colors(svg):
    """Ground of each cell that has a title, by the name of the cell."""
    found = re.findall(r"<title>(\w+): [^<]*</title><rect [^>]*fill=\"(#\w+)\"", svg)
    return dict(found)


def test_a_cell_has_the_color_of_the_highest_of_the_lowest_differences():
    table = failures((1, 0, 0.95, 0.65), (1, 0, 0.72, 0.99), (3, 2, 1.0, 0.9), (0, 3, 0.5, 0.55))
    svg = failure_map(table, examined((1, 0, 9), (2, 2, 5), (3, 3, 0)), SPACE)
    assert colors(svg) == {
        "A01": DIFFERENCE_COLORS[2],
        "C03": DIFFERENCE_COLORS[4],
        "D00": DIFFERENCE_COLORS[0],
        "C02": NO_FAILURE,
    }
    assert "A01: 2 failures, difference 72 points" in svg
    assert "C02: 1 object tried, no failure" in svg
    assert svg.count("<image") == 3
    words = texts(svg)
    assert "Reference minus detector, points: 4 failures in 3 cells" in words
    assert words.count("2") == 1


def test_an_engine_without_drops_does_not_count():
    table = failures((1, 0, 0.9, float("nan")), (1, 1, 0.6, 0.7))
    assert list(lowest_difference(table)) == [0.9, 0.6]


def test_a_search_without_failures_has_a_map():
    svg = failure_map(failures(), examined((1, 0, 9)), SPACE)
    assert colors(svg) == {"A01": NO_FAILURE}
    assert "Reference minus detector, points: 0 failures in 0 cells" in texts(svg)


def test_the_map_of_the_dataset_counts_objects():
    space = MeasureSpace(cells=4, complexity_range=(0, 4), graspability_range=(0, 4))
    objects = pd.DataFrame(
        [(0.5, 3.5)] + [(1.5, 3.5)] * 3 + [(9.0, -1.0)] * 7, columns=["complexity", "graspability"]
    )
    svg = dataset_map(objects, space, USUAL)
    assert colors(svg) == {"A00": COUNT_COLORS[0], "A01": COUNT_COLORS[2], "D03": COUNT_COLORS[3]}
    assert "Dataset: 11 objects in 3 cells" in texts(svg)


@pytest.mark.parametrize("cells", [1, 25])
def test_maps_name_all_rows_and_columns(cells):
    words = texts(failure_map(failures(), examined((0, 0, 1)), MeasureSpace(cells=cells)))
    assert [word for word in words if re.fullmatch(r"\d\d", word)] == [
        f"{number:02d}" for number in range(cells)
    ]
    assert sum(bool(re.fullmatch("[A-Z]", word)) for word in words) == cells

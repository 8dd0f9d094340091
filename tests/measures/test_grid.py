import numpy as np
import pandas as pd
import pytest

from egad.measures import MeasureSpace
from egad.measures import grid as space

SPACE = MeasureSpace()


def test_cells_clip_and_count_from_simple_and_easy():
    assert list(space.complexity_cells([0.0, 1.0, 1.17, 4.99, 5.0, 9.0], SPACE)) == [
        0, 0, 1, 24, 24, 24,
    ]  # fmt: skip
    assert list(space.difficulty_cells([0.004, 0.0039, 0.0005, 0.0], SPACE)) == [0, 0, 24, 24]


def test_coarse_cells_nest_in_equal_parts_of_the_range():
    values = np.linspace(0.0005, 0.004, 999)
    coarse = space.difficulty_cells(values, SPACE, 5)
    assert np.array_equal(coarse, space.difficulty_cells(values, SPACE, 25) // 5)


def test_labels_are_built_as_the_published_ones():
    assert space.labels([14, 14, 0], [12, 12, 0]) == ["M14_0", "M14_1", "A00_0"]


def test_coverage_counts_places_and_no_more_than_a_cell_has():
    objects = pd.DataFrame({"complexity_cell": [1] * 6 + [2], "difficulty_cell": [3] * 7})
    assert space.coverage(objects, SPACE) == pytest.approx(5 / 2500)
    assert space.filled_cells(objects, SPACE) == pytest.approx(2 / 625)
    counts = space.cell_counts(objects, SPACE)
    assert (counts.sum(), counts[3, 1], counts[3, 2]) == (7, 6, 1)  # row: graspability

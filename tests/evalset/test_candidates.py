import itertools

import numpy as np
import pandas as pd
import pytest

from egad.evalset.selection import candidates_by_cell, coarse_cells
from egad.pipeline.config import SelectEval, Space

SPACE = Space()
GRID = SelectEval(rows=2, columns=2, borrow=0.1)
ROW, COLUMN = 0.00175, 2.0  # height and width of a cell


def objects(*places):
    """Objects at rows and columns: (0.5, 1.5) is the middle of the second cell."""
    rows, columns = np.array(places, dtype=float).reshape(-1, 2).T
    return pd.DataFrame({"difficulty": 0.004 - rows * ROW, "complexity": 1 + columns * COLUMN})


def found(table, left_out=()):
    cells = candidates_by_cell(table, GRID, SPACE, left_out)
    return {cell: members.tolist() for cell, members in cells.items()}


def test_every_object_stands_for_its_own_cell():
    table = objects(*np.random.default_rng(0).random((100, 2)) * 2)
    cells = found(table)
    assert sorted(itertools.chain(*cells.values())) == list(range(100))
    own = coarse_cells(table, GRID, SPACE)
    assert all((own[members] == cell).all() for cell, members in cells.items())


def test_an_empty_cell_borrows_the_nearest_object_beside_it():
    table = objects((0.5, 0.5), (1.05, 0.5), (1.02, 0.5), (1.5, 0.5), (1.5, 1.5))
    assert found(table) == {0: [0], 2: [1, 2, 3], 3: [4]}  # nothing is near the second
    lonely = objects((1.05, 0.5), (1.02, 0.5), (1.5, 0.5), (1.5, 1.5))
    assert found(lonely) == {0: [1], 2: [0, 2], 3: [3]}
    assert found(lonely, left_out=[1]) == {0: [0], 2: [2], 3: [3]}
    assert found(lonely, left_out=[0, 1]) == {2: [2], 3: [3]}


def test_the_last_object_of_a_cell_is_not_borrowed():
    assert found(objects((1.02, 0.5), (1.5, 1.5))) == {2: [0], 3: [1]}


def test_an_object_is_borrowed_once():
    table = objects((1.01, 1.01), (1.5, 1.5))  # near three empty cells
    assert sorted(found(table).values()) == [[0], [1]]


def test_objects_outside_the_space_lie_at_its_edge():
    assert found(objects((-3, 0.5), (-1, 0.5), (0.2, 5), (0.5, 1.5))) == {0: [0, 1], 1: [2, 3]}


@pytest.mark.parametrize("far", [0.1, 0.3])
def test_how_far_is_a_setting(far):
    table = objects((1.2, 0.5), (1.5, 0.5))
    cells = candidates_by_cell(table, SelectEval(rows=2, columns=2, borrow=far), SPACE)
    assert (0 in cells) == (far > 0.2)

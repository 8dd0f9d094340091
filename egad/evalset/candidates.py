"""Which objects may stand for which cell of an evaluation set (ours)."""

from collections.abc import Iterable

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from egad.measures.space import complexity_cells, difficulty_cells
from egad.settings import SelectEval, Space

Indices = NDArray[np.int64]
Floats = NDArray[np.float64]


def candidates_by_cell(
    objects: pd.DataFrame, settings: SelectEval, space: Space, left_out: Iterable[int] = ()
) -> dict[int, Indices]:
    """The row numbers of the objects in each coarse cell that has any, row by row.

    A cell without any borrows the object that lies nearest to it, at most `settings.borrow` cells
    away, unless it is the last of its own cell. That counts as in the borrowing cell only.

    Args:
        objects: Columns of `tables.objects.OBJECTS`.
        settings: Rows, columns, how far a cell borrows.
        space: Ranges of the grid.
        left_out: Row numbers of objects that may not be chosen.
    """
    allowed = np.ones(len(objects), dtype=bool)
    allowed[list(left_out)] = False
    own = coarse_cells(objects, settings, space)
    places = _places(objects, settings, space)
    taken = np.where(allowed, own, -1)
    for cell in np.setdiff1d(np.arange(settings.rows * settings.columns), taken):
        away = _distances(places, divmod(int(cell), settings.columns))
        crowded = np.bincount(taken[taken >= 0], minlength=1)[taken] > 1
        away[(taken < 0) | (taken != own) | ~crowded] = np.inf
        if len(away) and away.min() <= settings.borrow:
            taken[away.argmin()] = cell
    return {int(cell): np.flatnonzero(taken == cell) for cell in np.unique(taken[taken >= 0])}


def coarse_cells(objects: pd.DataFrame, settings: SelectEval, space: Space) -> Indices:
    """The number of the cell that each object lies in, row by row, (n,)."""
    rows = difficulty_cells(objects["difficulty"], space, settings.rows)
    return rows * settings.columns + complexity_cells(
        objects["complexity"], space, settings.columns
    )


def _places(objects: pd.DataFrame, settings: SelectEval, space: Space) -> Floats:
    """Row and column of each object, (n, 2), as numbers that grow through the cells."""
    easy, hard = space.difficulty_range[::-1]
    simple, complicated = space.complexity_range
    rows = (objects["difficulty"].to_numpy(dtype=np.float64) - easy) / (hard - easy)
    columns = (objects["complexity"].to_numpy(dtype=np.float64) - simple) / (complicated - simple)
    places: Floats = np.clip(np.column_stack([rows, columns]), 0, 1)
    return places * [settings.rows, settings.columns]


def _distances(places: Floats, cell: tuple[int, int]) -> Floats:
    """How far places lie outside a cell, in cells, (n,)."""
    low = np.asarray(cell, dtype=np.float64)
    distances: Floats = np.linalg.norm(
        np.maximum(np.maximum(low - places, places - low - 1), 0), axis=1
    )
    return distances

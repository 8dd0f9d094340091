"""The space that objects are spread over: cells of complexity and graspability, and their names."""

import math
import string
from collections.abc import Iterable

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from egad._util.arrays import Ints
from egad.measures.parameters import MeasureSpace

Cells = Ints
Cell = tuple[int, int]


def cells(values: ArrayLike, low: float, high: float, count: int) -> Cells:
    """The cell of each value among `count` equal ones, the nearest if outside (as EGAD)."""
    scaled = (np.asarray(values, dtype=np.float64) - low) / (high - low) * count
    return np.clip(np.floor(scaled), 0, count - 1).astype(np.int64)


def complexity_cells(complexity: ArrayLike, space: MeasureSpace, count: int | None = None) -> Cells:
    """Cells along complexity, 0 = simplest."""
    return cells(complexity, *space.complexity_range, count or space.cells)


def difficulty_cells(
    graspability: ArrayLike, space: MeasureSpace, count: int | None = None
) -> Cells:
    """Cells along graspability, 0 = easiest, that is, of the highest grasp quality."""
    count = count or space.cells
    return count - 1 - cells(graspability, *space.graspability_range, count)


def graspability_limits(graspability: float, space: MeasureSpace) -> tuple[float, float]:
    """The least and the largest graspability of a cell; infinite at the ends of the range."""
    (low, high), count = space.graspability_range, space.cells
    cell = int(cells(graspability, low, high, count))
    below, above = (low + (high - low) * edge / count for edge in (cell, cell + 1))
    return below if cell > 0 else -math.inf, above if cell < count - 1 else math.inf


def cell_of(complexity: float, graspability: float, space: MeasureSpace) -> Cell:
    """The cell of an object: (complexity, difficulty)."""
    return int(complexity_cells(complexity, space)), int(difficulty_cells(graspability, space))


def cell_name(complexity_cell: int, difficulty_cell: int) -> str:
    """The name of a cell, with which labels begin: `M14`."""
    return f"{string.ascii_uppercase[difficulty_cell]}{complexity_cell:02d}"


def labels(complexity_cell: Iterable[int], difficulty_cell: Iterable[int]) -> list[str]:
    """Names as published, in the order given: `M14_3` is the fourth object of cell (14, M)."""
    seen: dict[tuple[int, int], int] = {}
    names = []
    for column, row in zip(complexity_cell, difficulty_cell, strict=True):
        slot = seen.get((column, row), 0)
        seen[column, row] = slot + 1
        names.append(f"{cell_name(column, row)}_{slot}")
    return names


def cell_counts(objects: pd.DataFrame, space: MeasureSpace) -> Cells:
    """How many objects each cell holds: (cells, cells), by difficulty, then complexity."""
    counts = np.zeros((space.cells, space.cells), np.int64)
    np.add.at(counts, (objects["difficulty_cell"], objects["complexity_cell"]), 1)
    return counts


def coverage(objects: pd.DataFrame, space: MeasureSpace, rows: int = 0) -> float:
    """Archive coverage of a table of objects, without some of the easiest rows: `coverage_of`."""
    return coverage_of(cell_counts(objects, space)[rows:], space)


def coverage_of(counts: Cells, space: MeasureSpace) -> float:
    """The fraction of all slots, one for each elite of a cell, that is filled (EGAD, Table III)."""
    filled = np.minimum(counts, space.elites_per_cell).sum()
    return float(filled / (counts.size * space.elites_per_cell))


def filled_cells(objects: pd.DataFrame, space: MeasureSpace) -> float:
    """The fraction of all cells that hold at least one object of a table."""
    return float((cell_counts(objects, space) > 0).mean())

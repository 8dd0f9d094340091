"""Which objects make the evaluation set: one a cell of a coarse grid, least alike as a set.

Source: EGAD, section IV-A, but optimised over the whole set at once (ours).
"""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from egad.evalset.labels import label_at, labels_of
from egad.measures.space import complexity_cells, difficulty_cells
from egad.settings import SelectEval, Space
from egad.tables import parquet
from egad.tables.evaluation import EVAL49

Indices = NDArray[np.int64]
Distances = NDArray[np.float64]


def select(
    objects: pd.DataFrame,
    distances: Distances,
    settings: SelectEval,
    space: Space,
    rng: np.random.Generator,
) -> pd.DataFrame:
    """Choose one object for every coarse cell that has any.

    The sum of the distances of all pairs is a local maximum: no exchange of one object for
    another of its cell makes it larger. The best of several random starts is taken.

    Args:
        objects: Columns of `tables.objects.OBJECTS`.
        distances: (n, n) distances of the objects.
        settings: Rows, columns, restarts.
        space: Ranges of the grid.
        rng: For the random starts.

    Returns:
        Columns of `tables.evaluation.EVAL49`, sorted by label.
    """
    if len(objects) == 0:
        return parquet.empty(EVAL49)
    rows, columns = _coarse_cells(objects, settings, space)
    candidates = candidates_by_cell(objects, settings, space)
    starts = (random_choice(candidates, rng) for _ in range(settings.restarts))
    found = [improve(start, candidates, distances) for start in starts]
    best = max(found, key=lambda chosen: total(chosen, distances))
    return _frame(objects.iloc[best], rows[best], columns[best], _nearest(best, distances))


def candidates_by_cell(objects: pd.DataFrame, settings: SelectEval, space: Space) -> list[Indices]:
    """The row numbers of the objects in each coarse cell that has any, row by row."""
    rows, columns = _coarse_cells(objects, settings, space)
    cell = rows * settings.columns + columns
    return [np.flatnonzero(cell == each) for each in np.unique(cell)]


def random_choice(candidates: Sequence[Indices], rng: np.random.Generator) -> Indices:
    """One candidate of each cell, drawn uniformly."""
    return np.array([cell[rng.integers(len(cell))] for cell in candidates])


def improve(start: Indices, candidates: Sequence[Indices], distances: Distances) -> Indices:
    """Exchange single objects until none makes the sum of all distances larger."""
    chosen = start.copy()
    gains = distances[:, chosen].sum(axis=1)  # of every object to the whole set
    changed = True
    while changed:
        changed = False
        for place, cell in enumerate(candidates):
            old = chosen[place]
            values = gains[cell] - distances[cell, old]
            new = cell[int(np.argmax(values))]
            if values.max() > gains[old] - distances[old, old] + 1e-12:
                gains += distances[:, new] - distances[:, old]
                chosen[place] = new
                changed = True
    return chosen


def total(chosen: Indices, distances: Distances) -> float:
    """Sum of the distances of all pairs of a set."""
    return float(distances[np.ix_(chosen, chosen)].sum() / 2)


def mean_distance(chosen: Indices, distances: Distances) -> float:
    """Mean distance of all pairs of a set; NaN for fewer than two objects."""
    pairs = len(chosen) * (len(chosen) - 1) / 2
    return total(chosen, distances) / pairs if pairs else float("nan")


def best_of_random(
    candidates: Sequence[Indices],
    distances: Distances,
    rng: np.random.Generator,
    draws: int = 1000,
) -> float:
    """The largest mean distance among random sets, to hold that of the chosen set against."""
    drawn = (random_choice(candidates, rng) for _ in range(draws))
    return max(mean_distance(chosen, distances) for chosen in drawn)


def empty_cells(chosen: pd.DataFrame, settings: SelectEval) -> list[str]:
    """Labels of the coarse cells that no object of the dataset lies in."""
    labels = labels_of(settings.rows, settings.columns)
    return [label for label in labels if label not in set(chosen["label"])]


def _coarse_cells(
    objects: pd.DataFrame, settings: SelectEval, space: Space
) -> tuple[Indices, Indices]:
    rows = difficulty_cells(objects["difficulty"], space, settings.rows)
    return rows, complexity_cells(objects["complexity"], space, settings.columns)


def _nearest(chosen: Indices, distances: Distances) -> NDArray[np.float64]:
    """Distance of each to the nearest other; NaN for a single one."""
    if len(chosen) == 1:
        return np.array([np.nan])
    among = distances[np.ix_(chosen, chosen)].copy()
    np.fill_diagonal(among, np.inf)
    return np.asarray(among.min(axis=1))


def _frame(
    chosen: pd.DataFrame, rows: Indices, columns: Indices, nearest: NDArray[np.float64]
) -> pd.DataFrame:
    table: pd.DataFrame = chosen.assign(
        object_label=chosen["label"],
        label=[label_at(row, column) for row, column in zip(rows, columns, strict=True)],
        row=rows,
        column=columns,
        nearest=nearest,
    )[EVAL49.names]
    return table.sort_values("label", ignore_index=True)

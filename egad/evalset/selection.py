"""Selection of the evaluation set: one object per cell of a coarse grid, diverse as a set.

Source: EGAD, section IV-A, but optimized over the whole set at once (ours).
"""

import re
import string
from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from egad._util.arrays import Floats, Ints
from egad.evalset.parameters import SelectEval
from egad.measures import MeasureSpace, complexity_cells, difficulty_cells
from egad.tables.evaluation import EVAL49

LABEL = re.compile(r"[A-Z][0-9]")
RESTARTS = 20  # random starts of the local search
Distances = NDArray[np.float64]
Check = Callable[[int], list[str]]


def label_at(row: int, column: int) -> str:
    """The name of a cell; A0 is the easiest and simplest."""
    return f"{string.ascii_uppercase[row]}{column}"


def labels_of(rows: int, columns: int) -> list[str]:
    """The names of all cells of a set, row by row."""
    return [label_at(row, column) for row in range(rows) for column in range(columns)]


def cell_of_label(label: str) -> tuple[int, int]:
    """Row and column of a name."""
    return string.ascii_uppercase.index(label[0]), int(label[1:])


def in_grid(labels: Iterable[str]) -> bool:
    """Whether all labels are names of cells, rather than names that objects have anyway."""
    return all(map(LABEL.fullmatch, labels))


def candidates_by_cell(
    objects: pd.DataFrame, settings: SelectEval, space: MeasureSpace, left_out: Iterable[int] = ()
) -> dict[int, Ints]:
    """The row numbers of the objects in each coarse cell that has any, row by row.

    A cell without any borrows the object that lies nearest to it, at most `settings.borrow` cells
    away, unless it is the last object of its own cell. A borrowed object counts as in the borrowing
    cell only. Where the graspability of some objects is certain, the other objects of their cell
    are not candidates.
    """
    allowed = np.ones(len(objects), dtype=bool)
    allowed[list(left_out)] = False
    own = coarse_cells(objects, settings, space)
    positions = _positions(objects, settings, space)
    taken = np.where(allowed, own, -1)
    for cell in np.setdiff1d(np.arange(settings.rows * settings.columns), taken):
        away = _distances(positions, divmod(int(cell), settings.columns))
        crowded = np.bincount(taken[taken >= 0], minlength=1)[taken] > 1
        away[(taken < 0) | (taken != own) | ~crowded] = np.inf
        if len(away) and away.min() <= settings.borrow:
            taken[away.argmin()] = cell
    certain = (objects["cell_confidence"] >= space.confidence).to_numpy()
    by_cell = {int(cell): np.flatnonzero(taken == cell) for cell in np.unique(taken[taken >= 0])}
    return {
        cell: rows[certain[rows]] if certain[rows].any() else rows for cell, rows in by_cell.items()
    }


def coarse_cells(objects: pd.DataFrame, settings: SelectEval, space: MeasureSpace) -> Ints:
    """The number of the cell that each object lies in, row by row, (n,)."""
    rows = difficulty_cells(objects["graspability"], space, settings.rows)
    return rows * settings.columns + complexity_cells(
        objects["complexity"], space, settings.columns
    )


def _positions(objects: pd.DataFrame, settings: SelectEval, space: MeasureSpace) -> Floats:
    """Row and column of each object, (n, 2), as numbers that grow through the cells."""
    easy, hard = space.graspability_range[::-1]
    simple, complicated = space.complexity_range
    rows = (objects["graspability"].to_numpy(dtype=np.float64) - easy) / (hard - easy)
    columns = (objects["complexity"].to_numpy(dtype=np.float64) - simple) / (complicated - simple)
    positions: Floats = np.clip(np.column_stack([rows, columns]), 0, 1)
    return positions * [settings.rows, settings.columns]


def _distances(positions: Floats, cell: tuple[int, int]) -> Floats:
    """How far positions lie outside a cell, in cells, (n,)."""
    low = np.asarray(cell, dtype=np.float64)
    distances: Floats = np.linalg.norm(
        np.maximum(np.maximum(low - positions, positions - low - 1), 0), axis=1
    )
    return distances


class Selection(NamedTuple):
    """What was chosen (`tables.evaluation.EVAL49`, sorted by label), as row numbers cell by cell.

    `left_out` has the row numbers of the objects with problems, and their problems.
    """

    table: pd.DataFrame
    chosen: Ints
    candidates: list[Ints]
    left_out: dict[int, list[str]]


def select(
    objects: pd.DataFrame,
    distances: Distances,
    settings: SelectEval,
    space: MeasureSpace,
    rng: np.random.Generator,
    problems: Check | None = None,
) -> Selection:
    """Choose one object for every coarse cell that has any, or one nearby to borrow.

    The sum of the (n, n) distances of all pairs is a local maximum: no exchange of one or two
    objects for others of their cells makes it larger. The best of several random starts is taken.
    An object with `problems`, by its row number, is left out and the rest is chosen again, so only
    objects that would be chosen are checked.
    """
    left_out: dict[int, list[str]] = {}
    fine: set[int] = set()
    while True:
        by_cell = candidates_by_cell(objects, settings, space, left_out)
        candidates = list(by_cell.values())
        chosen = _best_of_restarts(candidates, distances, rng)
        found = {int(each): problems(int(each)) if problems else [] for each in set(chosen) - fine}
        fine |= {each for each, wrong in found.items() if not wrong}
        bad = {each: wrong for each, wrong in found.items() if wrong}
        if not bad:
            cells = np.array(list(by_cell), dtype=np.int64)
            borrowed = coarse_cells(objects, settings, space)[chosen] != cells
            nearest = nearest_distances(chosen, distances)
            table = selection_table(
                objects.iloc[chosen], cells, settings.columns, borrowed, nearest
            )
            return Selection(table, chosen, candidates, left_out)
        left_out |= bad


def _best_of_restarts(
    candidates: Sequence[Ints], distances: Distances, rng: np.random.Generator
) -> Ints:
    starts = (random_choice(candidates, rng) for _ in range(RESTARTS))
    found = [improve(start, candidates, distances) for start in starts]
    return max(found, key=lambda chosen: total(chosen, distances))


def random_choice(candidates: Sequence[Ints], rng: np.random.Generator) -> Ints:
    """One candidate of each cell, drawn uniformly."""
    return np.array([cell[rng.integers(len(cell))] for cell in candidates], dtype=np.int64)


def improve(start: Ints, candidates: Sequence[Ints], distances: Distances) -> Ints:
    """Exchange one or two objects until no such exchange makes the sum of distances larger."""
    chosen = _exchange_singles(start, candidates, distances)
    while (better := _exchange_pair(chosen, candidates, distances)) is not None:
        chosen = _exchange_singles(better, candidates, distances)
    return chosen


def _exchange_pair(chosen: Ints, candidates: Sequence[Ints], distances: Distances) -> Ints | None:
    """The set after the first exchange of two objects that improves it; None if there is none."""
    if len(candidates) < 2:
        return None
    gains = distances[:, chosen].sum(axis=1)
    objects, ends = np.concatenate(candidates), np.cumsum([len(cell) for cell in candidates])
    cells = np.repeat(np.arange(len(candidates)), np.diff(ends, prepend=0))
    own = distances[objects, chosen[cells]]  # to the chosen object of the same cell
    for first, rows in enumerate(candidates[:-1]):
        old, end = chosen[first], ends[first]
        columns, others = objects[end:], distances[np.ix_(rows, chosen)][:, cells[end:]]
        value = gains[rows, None] - (distances[rows, old, None] + others)
        value += gains[columns] - (distances[columns, old] + own[end:])
        value += distances[np.ix_(rows, columns)]
        later = chosen[first + 1 :]
        now = gains[old] + gains[later] - distances[old, later]
        best = np.maximum.reduceat(value.max(axis=0), ends[first:-1] - end)
        if len(better := np.flatnonzero(best > now + 1e-9)):
            second = first + 1 + better[0]
            among = value[:, ends[second - 1] - end : ends[second] - end]
            row, column = np.unravel_index(among.argmax(), among.shape)
            exchanged = chosen.copy()
            exchanged[[first, second]] = rows[row], candidates[second][column]
            return exchanged
    return None


def _exchange_singles(start: Ints, candidates: Sequence[Ints], distances: Distances) -> Ints:
    chosen = start.copy()
    gains = distances[:, chosen].sum(axis=1)  # of every object to the whole set
    changed = True
    while changed:
        changed = False
        for cell_of_label, cell in enumerate(candidates):
            old = chosen[cell_of_label]
            values = gains[cell] - distances[cell, old]
            new = cell[int(np.argmax(values))]
            if values.max() > gains[old] - distances[old, old] + 1e-12:
                gains += distances[:, new] - distances[:, old]
                chosen[cell_of_label] = new
                changed = True
    return chosen


def total(chosen: Ints, distances: Distances) -> float:
    """Sum of the distances of all pairs of a set."""
    return float(distances[np.ix_(chosen, chosen)].sum() / 2)


def mean_distance(chosen: Ints, distances: Distances) -> float:
    """Mean distance of all pairs of a set; NaN for fewer than two objects."""
    pairs = len(chosen) * (len(chosen) - 1) / 2
    return total(chosen, distances) / pairs if pairs else float("nan")


def bound(candidates: Sequence[Ints], distances: Distances) -> float:
    """An upper bound of the mean distance of any set.

    Each object of a set lies at most as far from the others as from the farthest of their cells.
    """
    pairs = len(candidates) * (len(candidates) - 1)
    if not pairs:
        return float("nan")
    farthest = np.array([distances[:, cell].max(axis=1) for cell in candidates])
    best = [
        (farthest[:, cell].sum(axis=0) - farthest[n, cell]).max()
        for n, cell in enumerate(candidates)
    ]
    return float(sum(best)) / pairs


def best_of_random(
    candidates: Sequence[Ints], distances: Distances, rng: np.random.Generator, draws: int = 1000
) -> float:
    """The largest mean distance among random sets, to compare with that of the chosen set."""
    drawn = (random_choice(candidates, rng) for _ in range(draws))
    return max(mean_distance(chosen, distances) for chosen in drawn)


def empty_cells(chosen: pd.DataFrame, settings: SelectEval) -> list[str]:
    """Labels of the coarse cells that no object of the set represents."""
    labels = labels_of(settings.rows, settings.columns)
    return [label for label in labels if label not in set(chosen["label"])]


def nearest_distances(chosen: Ints, distances: Distances) -> NDArray[np.float64]:
    """Distance of each object to the nearest other one; NaN for a single one."""
    if len(chosen) < 2:
        return np.full(len(chosen), np.nan)
    among = distances[np.ix_(chosen, chosen)].copy()
    np.fill_diagonal(among, np.inf)
    return np.asarray(among.min(axis=1))


def take_all(
    objects: pd.DataFrame, distances: Distances, settings: SelectEval, space: MeasureSpace
) -> pd.DataFrame:
    """All objects, under their labels, as `EVAL49`, sorted by label; several may share a cell."""
    cells, everything = coarse_cells(objects, settings, space), np.arange(len(objects))
    borrowed, nearest = np.zeros(len(objects), bool), nearest_distances(everything, distances)
    table = selection_table(objects, cells, settings.columns, borrowed, nearest)
    return table.assign(label=table["object_label"]).sort_values("label", ignore_index=True)


def selection_table(
    chosen: pd.DataFrame,
    cells: Ints,
    columns: int,
    borrowed: NDArray[np.bool_],
    nearest: NDArray[np.float64],
) -> pd.DataFrame:
    """The table of a set, `EVAL49`, sorted by label: cells are numbered row by row."""
    corners = [divmod(int(cell), columns) for cell in cells]
    table: pd.DataFrame = chosen.assign(
        object_label=chosen["label"],
        label=[label_at(row, column) for row, column in corners],
        row=cells // columns,
        column=cells % columns,
        borrowed=borrowed,
        nearest=nearest,
    )[EVAL49.names]
    return table.sort_values("label", ignore_index=True)

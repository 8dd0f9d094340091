"""An evaluation set chosen by somebody else: its objects already have labels."""

import logging
from collections.abc import Iterable, Mapping
from pathlib import Path

import numpy as np
import pandas as pd

from egad.errors import UserError
from egad.evalset.parameters import SelectEval
from egad.evalset.selection import (
    LABEL,
    Distances,
    cell_of_label,
    label_at,
    nearest_distances,
    selection_table,
)
from egad.io import csv_lines

log = logging.getLogger(__name__)
NEEDED = ("id", "label")


def labels_by_name(ids: Iterable[str]) -> dict[str, str]:
    """The objects whose names are labels, such as C4."""
    return {name: name for name in ids if LABEL.fullmatch(name)}


def read_labels(path: Path) -> dict[str, str]:
    """Labels by the ids of objects, from a CSV file with the columns id and label, or UserError."""
    try:
        rows = csv_lines(path, NEEDED)
    except OSError as error:
        raise UserError(f"{path}: not a CSV file: {error}") from error
    names = [name.lower() for name in rows[0][1]] if rows else []
    if missing := [name for name in NEEDED if name not in names]:
        raise UserError(f"{path}: the column {missing[0]} is missing; needed: id, label")
    labels: dict[str, str] = {}
    for line, cells in rows[1:]:
        row = dict(zip(names, cells, strict=False))
        name, label = (row.get(key, "") for key in NEEDED)
        if not name:
            raise UserError(f"{path}, line {line}: the id is missing")
        if not LABEL.fullmatch(label):
            raise UserError(f"{path}, line {line}: label is {label!r}; allowed: labels such as C4")
        if name in labels:
            raise UserError(f"{path}, line {line}: the object {name} has two labels")
        labels[name] = label
    return labels


def take(
    objects: pd.DataFrame, labels: Mapping[str, str], distances: Distances, settings: SelectEval
) -> pd.DataFrame:
    """The objects of `OBJECTS` with labels, by id, as `tables.evaluation.EVAL49`, sorted by label.

    Ids that are not among them are named in the log. UserError if no object has a label, two have
    the same, or one lies outside the grid.
    """
    if unknown := sorted(set(labels) - set(objects["id"])):
        log.warning("labelled objects that are not in the dataset: %s", ", ".join(unknown))
    ids = objects["id"].tolist()
    placed = sorted((labels[name], row) for row, name in enumerate(ids) if name in labels)
    names = [label for label, _ in placed]
    if not placed:
        raise UserError("no object has a label of the evaluation set, such as C4")
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise UserError(f"two objects of the evaluation set have the same label: {twice[0]}")
    for label in names:
        row, column = cell_of_label(label)
        if row >= settings.rows or column >= settings.columns:
            last = label_at(settings.rows - 1, settings.columns - 1)
            raise UserError(
                f"the label {label} lies outside the grid, which ends at {last}: raise "
                "select_eval.rows or select_eval.columns"
            )
    chosen = np.array([row for _, row in placed])
    cells = np.array([row * settings.columns + column for row, column in map(cell_of_label, names)])
    return selection_table(
        objects.iloc[chosen],
        cells,
        settings.columns,
        np.zeros(len(chosen), dtype=bool),
        nearest_distances(chosen, distances),
    )

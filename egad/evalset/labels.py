"""Names in the evaluation set: a letter for the row, a digit for the column, such as C4."""

import re
import string

LABEL = re.compile(r"[A-Z][0-9]")


def label_at(row: int, column: int) -> str:
    """The name of a place; A0 is the easiest and simplest."""
    return f"{string.ascii_uppercase[row]}{column}"


def labels_of(rows: int, columns: int) -> list[str]:
    """The names of all places of a set, row by row."""
    return [label_at(row, column) for row in range(rows) for column in range(columns)]


def place(label: str) -> tuple[int, int]:
    """Row and column of a name."""
    return string.ascii_uppercase.index(label[0]), int(label[1:])

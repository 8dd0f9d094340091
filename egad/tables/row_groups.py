"""Tables that are too large to be read at once: one group of rows at a time, in any order."""

from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from egad.tables import parquet
from egad.tables.columns import check_names
from egad.tables.untrusted import DAMAGED, Source, unreadable


class RowGroups:
    """The groups of rows of a Parquet file."""

    def __init__(self, path: Path, names: Sequence[str]) -> None:
        """Open a table with some columns, without reading its rows, or raise `TableError`."""
        self._path = path
        try:
            self._source = Source(path)
        except DAMAGED as error:
            raise unreadable(path, error) from error
        self.sizes = self._source.group_rows
        parquet.check_columns(path, list(names))

    def read(self, group: int, names: Sequence[str]) -> pd.DataFrame:
        """Some columns of a group, by its number; `TableError` if it is damaged."""
        try:
            frame: pd.DataFrame = self._source.read(names, group).to_pandas()
        except DAMAGED as error:
            raise unreadable(self._path, error) from error
        check_names(frame, self._path)
        return frame

"""Tables that are too large to be read at once: one group of rows after the other, in any order."""

from collections.abc import Sequence
from pathlib import Path

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from egad.errors import TableError
from egad.tables import parquet
from egad.tables.promises import check_names, check_promises

_DAMAGED = (OSError, pa.ArrowException, UnicodeDecodeError)


class RowGroups:
    """The groups of rows of a Parquet file."""

    def __init__(self, path: Path, names: Sequence[str]) -> None:
        """Look at a table without reading its rows.

        Args:
            path: The file.
            names: Columns that it must have.

        Raises:
            TableError: The file is missing, is not Parquet, is cut short, lacks a column, or would
                take too much memory.
        """
        self._path = path
        try:
            check_promises(path)
            with pq.ParquetFile(path) as file:
                about = file.metadata
                self.sizes = [about.row_group(n).num_rows for n in range(about.num_row_groups)]
        except _DAMAGED as error:
            raise self._damaged(error) from error
        parquet.check_columns(path, list(names))

    def read(self, group: int, names: Sequence[str]) -> pd.DataFrame:
        """Some columns of a group, by its number.

        Raises:
            TableError: The file is damaged.
        """
        try:
            with pq.ParquetFile(self._path) as file:
                frame: pd.DataFrame = file.read_row_group(group, list(names)).to_pandas()
        except _DAMAGED as error:
            raise self._damaged(error) from error
        check_names(frame, self._path)
        return frame

    def _damaged(self, error: Exception) -> TableError:
        return TableError(f"{self._path}: not a readable Parquet file ({error})")

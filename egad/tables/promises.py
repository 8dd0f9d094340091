"""What a Parquet file promises, checked before memory is taken; and names that may be file names.

A file of some hundred bytes can promise any number of rows, each of them a reference to the same
megabyte of text.
"""

import re
from collections.abc import Sequence
from pathlib import Path

import pandas as pd
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from egad.tables.seal import is_whole

MOST_BYTES = 4 << 30  # of a table in memory
LABELS = ("label", "object_label")
_WIDEST = 8  # bytes of a number
_UNSAFE = re.compile(r"[/\\\x00]|^\.{1,2}$")


class TableError(ValueError):
    """A Parquet file is missing, damaged, or does not have the columns of its schema."""


def unreadable(path: Path, why: object) -> TableError:
    """What to say of a file that cannot be read as a table."""
    advice = "; if the workflow made it, delete it and run again" if path.exists() else ""
    return TableError(f"{path}: not a readable Parquet file ({why}){advice}")


def check_promises(path: Path) -> None:
    """Look at what a table would take, without reading its rows.

    Raises:
        TableError: It would take too much, or is not as it was sealed.
        ArrowException: It is damaged; also OSError.
    """
    if is_whole(path) is False:  # pyarrow would end the process for some damages
        raise unreadable(path, "altered since it was written")
    with pq.ParquetFile(path) as file:
        about = file.metadata
        columns = [
            about.row_group(group).column(number)
            for group in range(about.num_row_groups)
            for number in range(about.num_columns)
        ]
        _check(path, _WIDEST * (about.num_rows + sum(each.num_values for each in columns)))
        _check(path, sum(each.total_uncompressed_size for each in columns))
        texts = [each for each in columns if each.physical_type.endswith("BYTE_ARRAY")]
        if sum(each.num_values * each.total_uncompressed_size for each in texts) > MOST_BYTES:
            _check(path, _unpacked(path, sorted({each.path_in_schema for each in texts})))


def check_names(frame: pd.DataFrame, path: Path, columns: Sequence[str] = LABELS) -> None:
    """Make sure that names of objects can be names of files, in whatever folder.

    Raises:
        TableError: One cannot; the text has it.
    """
    for column in (name for name in columns if name in frame):
        for name in frame[column].unique():
            if isinstance(name, str) and _UNSAFE.search(name):
                raise TableError(f"{path}: the {column} {name!r} cannot be the name of a file")


def _unpacked(path: Path, texts: list[str]) -> int:
    """Bytes of all texts of a table, each as often as it is there."""
    with pq.ParquetFile(path, read_dictionary=texts) as file:
        table = file.read(columns=texts)
    return sum(_text_bytes(chunk) for column in table.columns for chunk in column.chunks)


def _text_bytes(values: pa.Array) -> int:
    while pa.types.is_list(values.type) or pa.types.is_large_list(values.type):
        values = values.flatten()
    if not pa.types.is_dictionary(values.type):
        return int(values.nbytes)
    lengths = pc.cast(pc.binary_length(values.dictionary), pa.int64())
    return int(pc.sum(lengths.take(values.indices)).as_py() or 0)


def _check(path: Path, size: int) -> None:
    if not 0 <= size <= MOST_BYTES:
        raise TableError(f"{path}: {size:,} bytes in memory; at most {MOST_BYTES:,} are read")

"""What a Parquet file promises, checked before memory is taken; and names that may be file names.

A file of some hundred bytes can promise any number of rows, each of them a reference to the same
megabyte of text.
"""

import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import pandas as pd
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from egad.errors import TableError
from egad.tables.pages import DIFFERENCES, Page, pages
from egad.tables.seal import is_whole

MOST_BYTES = 4 << 30  # of a table in memory
MOST_PAGES = 100_000  # of a column in a group of rows
BATCH = 8192  # rows that are in memory at a time where a table is streamed
LABELS = ("label", "object_label")
_WIDEST = 8  # bytes of a number
_UNSAFE = re.compile(r"[/\\\x00]|^\.{1,2}$")


def unreadable(path: Path, why: object) -> TableError:
    """What to say of a file that cannot be read as a table."""
    advice = "; if the workflow made it, delete it and run again" if path.exists() else ""
    return TableError(f"{path}: not a readable Parquet file ({why}){advice}")


def check_promises(path: Path) -> None:
    """Look at what a table would take, without keeping its rows.

    The footer is not trusted: sizes are those of the pages, by which a reader takes memory.

    Raises:
        TableError: It would take too much, or is not as it was sealed.
        ArrowException: It is damaged; also OSError.
    """
    if is_whole(path) is False:  # pyarrow would end the process for some damages
        raise unreadable(path, "altered since it was written")
    with pq.ParquetFile(path) as file:
        about = file.metadata
        _check(path, _WIDEST * about.num_rows)
        kept = [_taken(path, about, number) for number in range(about.num_columns)]
    _check(path, sum(column.size for column in kept))
    if sum(column.text for column in kept) > MOST_BYTES:
        _check_unpacked(path, [column.name for column in kept if column.text])


class _Column(NamedTuple):
    """What a column takes: its name, bytes, and bytes of text if each is as long as can be."""

    name: str
    size: int
    text: int


def _taken(path: Path, about: pq.FileMetaData, number: int) -> _Column:
    """What the pages of a column take.

    Raises:
        TableError: It is too much, or cannot be known without unpacking all of it.
    """
    column = about.schema.column(number)
    is_text = column.physical_type.endswith("BYTE_ARRAY")
    width = max(_WIDEST, column.length or 0)
    size = text = 0
    for group in range(about.num_row_groups):
        chunk = about.row_group(group).column(number)
        unpacked, values = 0, chunk.num_values
        for page in _pages(path, chunk):
            if is_text and page.encoding == DIFFERENCES:
                raise TableError(f"{path}: {column.path} is DELTA_BYTE_ARRAY, which is not read")
            unpacked, values = unpacked + page.size, values + page.values
            _check(path, size + unpacked + width * (values - chunk.num_values))
        size += max(unpacked, width * values)
        text += unpacked * values if is_text else 0
        _check(path, size)
    return _Column(column.path, size, text)


def _pages(path: Path, chunk: pq.ColumnChunkMetaData) -> Iterator[Page]:
    try:
        for number, page in enumerate(pages(path, chunk)):
            if number >= MOST_PAGES:
                raise TableError(f"{path}: more than {MOST_PAGES:,} pages of a column")
            yield page
    except TableError:
        raise
    except ValueError as error:
        raise TableError(f"{path}: not a readable Parquet file ({error})") from error


def check_names(frame: pd.DataFrame, path: Path, columns: Sequence[str] = LABELS) -> None:
    """Make sure that names of objects can be names of files, in whatever folder.

    Raises:
        TableError: One cannot; the text has it.
    """
    for column in (name for name in columns if name in frame):
        for name in frame[column].unique():
            if isinstance(name, str) and _UNSAFE.search(name):
                raise TableError(f"{path}: the {column} {name!r} cannot be the name of a file")


def _check_unpacked(path: Path, texts: list[str]) -> None:
    """Count the bytes of all texts of a table, each as often as it is there, up to the bound."""
    size = 0
    with pq.ParquetFile(path, read_dictionary=texts) as file:
        for batch in file.iter_batches(BATCH, columns=texts):
            size += sum(_text_bytes(column) for column in batch.columns)
            _check(path, size)


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

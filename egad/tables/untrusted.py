"""Reading Parquet files that may be damaged or made to unfold to any size.

A table of this program has a seal, which shows every change, and is read in this process. One
without a seal is read in a process with a limit on memory; pyarrow may also end that process if the
file is damaged. The seal is not a signature: a file that was sealed on purpose is as trusted as the
program that sealed it.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from egad._util.input_limits import MAX_COLUMNS, MAX_FOREIGN_TABLE_BYTES, MAX_ROWS, MAX_TABLE_BYTES
from egad._util.limited import FailedError, LimitError, limited
from egad._util.memory import is_out_of_memory
from egad.errors import TableError
from egad.tables.seal import is_whole

BATCH = 8192  # rows that are in memory at a time where a table is streamed
DAMAGED = (OSError, pa.ArrowException, UnicodeDecodeError, FailedError, LimitError)


def unreadable(path: Path, why: object) -> TableError:
    """The error for a file that cannot be read as a table; raises one that says nothing of it."""
    if isinstance(why, Exception) and is_out_of_memory(why):
        raise why
    advice = "; if the workflow made it, delete it and run again" if path.exists() else ""
    return TableError(f"{path}: not a readable Parquet file ({why}){advice}")


class Source:
    """A Parquet file whose seal and size have been checked."""

    def __init__(self, path: Path) -> None:
        """Check a file without its rows: `TableError` if too large or altered, else `DAMAGED`."""
        self._path = path
        sealed = is_whole(path)
        if sealed is False:
            raise unreadable(path, "altered since it was written")
        self._sealed = bool(sealed)
        self.group_rows = _group_rows(path) if self._sealed else limited(_group_rows, path)

    def read(self, columns: Sequence[str], group: int | None = None) -> pa.Table:
        """Some columns, of all rows or of one group; raises as `Source` does."""
        if self._sealed:
            return _read(self._path, columns, group)
        packed = limited(_read_packed, self._path, list(columns), group)
        return pa.ipc.open_stream(packed).read_all()

    def batches(self, columns: Sequence[str]) -> Iterator[pa.RecordBatch]:
        """Some columns, `BATCH` rows at a time; errors are those of `read`."""
        if not self._sealed:
            yield from self.read(columns).to_batches(BATCH)
            return
        with pq.ParquetFile(self._path) as file:
            yield from file.iter_batches(BATCH, columns=list(columns))


def _group_rows(path: Path) -> list[int]:
    """How many rows each group of a file has, if these are not too many."""
    _check(path, "bytes", path.stat().st_size, MAX_TABLE_BYTES)
    with pq.ParquetFile(path) as file:
        about = file.metadata
        groups = [about.row_group(number) for number in range(about.num_row_groups)]
    _check(path, "columns", about.num_columns, MAX_COLUMNS)
    _check(path, "rows", max(about.num_rows, sum(group.num_rows for group in groups)), MAX_ROWS)
    unpacked = sum(max(group.total_byte_size, 0) for group in groups)
    _check(path, "bytes unpacked", unpacked, MAX_TABLE_BYTES)
    return [group.num_rows for group in groups]


def _check(path: Path, what: str, count: int, most: int) -> None:
    if count > most:
        raise TableError(f"{path}: {count:,} {what}; at most {most:,} are read")


def _read(path: Path, columns: Sequence[str], group: int | None) -> pa.Table:
    names = list(columns)
    with pq.ParquetFile(path) as file:
        return file.read(names) if group is None else file.read_row_group(group, names)


def _read_packed(path: Path, columns: Sequence[str], group: int | None) -> pa.Buffer:
    """The same as an Arrow stream, in which repeated texts are not shared."""
    table = _read(path, columns, group)
    table = table.cast(pa.schema([(field.name, _plain(path, field)) for field in table.schema]))
    _check(path, "bytes in memory", table.nbytes, MAX_FOREIGN_TABLE_BYTES)
    sink = pa.BufferOutputStream()
    with pa.ipc.new_stream(sink, table.schema) as stream:
        stream.write_table(table)
    return sink.getvalue()


def _plain(path: Path, field: pa.Field) -> pa.DataType:
    """The type of a column without dictionaries, which could unfold later."""
    kind = field.type
    if pa.types.is_dictionary(kind):
        kind = kind.value_type
    values = kind.value_type if pa.types.is_list(kind) or pa.types.is_large_list(kind) else kind
    if pa.types.is_nested(values) or pa.types.is_dictionary(values):
        raise TableError(f"{path}: {field.name} is of the type {field.type}, which is not read")
    return kind

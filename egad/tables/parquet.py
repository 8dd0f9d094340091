"""Reading and writing of Parquet tables: the only way in and out.

A table is written under a temporary name and then renamed, so a file that exists is complete.
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from egad import __version__
from egad._util.files import atomic_output
from egad.errors import TableError
from egad.tables import origin, seal
from egad.tables.columns import check_names
from egad.tables.untrusted import DAMAGED, Source, unreadable

_NOTES, _ORIGIN = "egad", "egad-origin"
OLD = {  # columns of older versions by what they are called now, for messages
    "graspability": "difficulty",
    "graspability_std": "difficulty_std",
    "archive_graspability": "archive_difficulty",
    "antipodal_success_rate": "simulated_graspability",
}


def records(frame: pd.DataFrame) -> list[dict[str, Any]]:
    """The rows of a table, each as a dictionary by column."""
    return [{str(name): value for name, value in row.items()} for row in frame.to_dict("records")]


def empty(schema: pa.Schema) -> pd.DataFrame:
    """A table with the columns of a schema and no rows."""
    frame: pd.DataFrame = schema.empty_table().to_pandas()
    return frame


def write(
    frame: pd.DataFrame,
    schema: pa.Schema,
    path: Path,
    notes: Mapping[str, Any] | None = None,
    group: int | None = None,
) -> None:
    """Write the columns of a schema as a table, atomically, sealed, with its origin and notes.

    A `group` of rows can be read without the others (`RowGroups`): a million rows if None.
    """
    columns = frame[schema.names] if len(frame) else empty(schema)
    table = pa.Table.from_pandas(columns, schema=schema, preserve_index=False)
    kept = {_NOTES: notes, _ORIGIN: origin.noted(path.parent)}
    texts = {key: json.dumps(value, sort_keys=True) for key, value in kept.items() if value}
    table = table.replace_schema_metadata(texts or None)
    with atomic_output(path) as temporary:
        with pq.ParquetWriter(temporary, table.schema, compression="zstd") as writer:
            writer.write_table(table, group)
            writer.add_key_value_metadata({seal.KEY: seal.BLANK})
        seal.seal(temporary)


def columns(path: Path) -> list[str]:
    """Names of the columns of a table, or `TableError`."""
    return list(schema_of(path).names)


def check_columns(path: Path, names: list[str]) -> None:
    """Raise `TableError` if a table lacks a column."""
    found = columns(path)
    if missing := [name for name in names if name not in found]:
        old = [f"{OLD[name]} is now {name}" for name in missing if OLD.get(name) in found]
        renamed = f" ({', '.join(old)})" if old else ""
        listed = f"{', '.join(missing)}{renamed}"
        raise TableError(f"{path}: columns are missing: {listed}{_advice(path)}")


def _advice(path: Path) -> str:
    """What to do about a table with other columns, if egad wrote it."""
    writer = origin_of(path).get("program")
    if not writer:
        return ""
    if writer == __version__:
        return "; make it again"
    return f"; egad {writer} wrote it, this is egad {__version__}: make it again"


def schema_of(path: Path) -> pa.Schema:
    """The columns of a table, or `TableError`."""
    try:
        return pq.read_schema(path)
    except DAMAGED as error:
        raise unreadable(path, error) from error


def notes(path: Path) -> dict[str, Any]:
    """What was kept in a file beside its rows; nothing if it has no such notes; or `TableError`."""
    return _kept(path, _NOTES)


def origin_of(path: Path) -> dict[str, Any]:
    """The `egad.tables.origin.Origin` of a table; nothing if it has none; or `TableError`."""
    return _kept(path, _ORIGIN)


def _kept(path: Path, key: str) -> dict[str, Any]:
    kept = (schema_of(path).metadata or {}).get(key.encode())
    try:
        found = json.loads(kept) if kept else {}
    except (ValueError, RecursionError) as error:
        raise TableError(f"{path}: its metadata {key} is not JSON") from error
    if not isinstance(found, dict):
        raise TableError(f"{path}: its metadata {key} is not a table of values")
    return found


def read(path: Path, schema: pa.Schema) -> pd.DataFrame:
    """The columns of a schema, or `TableError`; NaN if its optional ones are all missing."""
    try:
        source = Source(path)
        optional = {field.name for field in schema if b"optional" in (field.metadata or {})}
        # one with only some of its optional columns is damaged
        missing = optional if optional.isdisjoint(columns(path)) else set[str]()
        names = [name for name in schema.names if name not in missing]
        check_columns(path, names)
        table = source.read(names).select(names)
        plain = pa.schema([(name, schema.field(name).type) for name in names])
        frame: pd.DataFrame = table.cast(plain).to_pandas()
    except DAMAGED as error:
        raise unreadable(path, error) from error
    check_names(frame, path)
    return frame.reindex(columns=schema.names) if missing else frame


def batches(path: Path, names: list[str]) -> Iterator[pd.DataFrame]:
    """Read some columns of a table, `BATCH` rows at a time, or raise `TableError`."""
    try:
        source = Source(path)
        check_columns(path, names)
        for batch in source.batches(names):
            frame = batch.to_pandas()
            check_names(frame, path)
            yield frame
    except DAMAGED as error:
        raise unreadable(path, error) from error


def distinct(path: Path, name: str) -> set[Any]:
    """The distinct values of a column; raises what `batches` raises."""
    return {value for rows in batches(path, [name]) for value in rows[name]}


class RowGroups:
    """The groups of rows of a table too large to be read at once, in any order."""

    def __init__(self, path: Path, names: Sequence[str]) -> None:
        """Open a table with some columns, without reading its rows, or raise `TableError`."""
        self._path = path
        try:
            self._source = Source(path)
        except DAMAGED as error:
            raise unreadable(path, error) from error
        self.sizes = self._source.group_rows
        check_columns(path, list(names))

    def read(self, group: int, names: Sequence[str]) -> pd.DataFrame:
        """Some columns of a group, by its number; `TableError` if it is damaged."""
        try:
            frame: pd.DataFrame = self._source.read(names, group).to_pandas()
        except DAMAGED as error:
            raise unreadable(self._path, error) from error
        check_names(frame, self._path)
        return frame

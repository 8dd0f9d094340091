"""Parquet files that unfold to very much, or whose footers say something else than their pages."""

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

SCHEMA = pa.schema([("id", pa.string()), ("voxels", pa.large_binary()), ("x", pa.float64())])
MEGABYTE = 1 << 20
WIDE = 100_000_000
REFUSED = "TableError: .*: not a readable Parquet file|TableError: .* bytes in memory"


def repeated(value, count, kind):
    zeros = pa.array(np.zeros(count, np.int8))
    return pa.DictionaryArray.from_arrays(zeros, pa.array([value], kind))


def table(path, count, name="a", voxels=b"", **options):
    rows = {
        "id": repeated(name, count, pa.string()),
        "voxels": repeated(voxels, count, pa.binary()),
        "x": pa.array(np.zeros(count)),
    }
    pq.write_table(pa.table(rows), path, compression="zstd", store_schema=False, **options)


def with_footer(path, change):
    """A file whose footer says something else, in as many bytes."""
    data = path.read_bytes()
    start = len(data) - 8 - int.from_bytes(data[-8:-4], "little")
    footer = change(data[start:-8])
    assert len(footer) == len(data) - 8 - start
    path.write_bytes(data[:start] + footer + data[-8:])


def varint(value):
    value, parts = 2 * value, []
    while value:
        parts.append(value & 127 | 128)
        value >>= 7
    return bytes([*parts[:-1], parts[-1] & 127])


def lying(path, number, **texts):
    """A table of much text of which the footer says that it takes one byte."""
    table(path, 5000, **texts)
    size = varint(pq.ParquetFile(path).metadata.row_group(0).column(number).total_uncompressed_size)
    padded = b"\x82" + b"\x80" * (len(size) - 2) + b"\0"
    with_footer(path, lambda footer: footer.replace(size, padded))
    about = pq.ParquetFile(path).metadata.row_group(0).column(number)
    assert about.total_uncompressed_size == 1


def rows(path, count):
    """Many rows that are alike."""
    column = pa.DictionaryArray.from_arrays(pa.array(np.zeros(count, np.int8)), ["a"])
    pq.write_table(pa.table({"id": column}), path, store_schema=False)


def categories(path):
    """The same text often, and the note of pandas that it is to stay a category."""
    pq.write_table(pa.table({"id": repeated("a" * MEGABYTE, 5000, pa.string())}), path)


def nested_categories(path):
    column = pa.ListArray.from_arrays([0, 5000], repeated("a" * MEGABYTE, 5000, pa.string()))
    pq.write_table(pa.table({"id": column}), path)


def shared_beginnings(path):
    """Texts each of which may be as long as all that is in the file."""
    options = {"use_dictionary": False, "column_encoding": {"id": "DELTA_BYTE_ARRAY"}}
    pq.write_table(pa.table({"id": ["a" * 1_000_000] * 100}), path, **options)


def wide(path):
    column = pa.nulls(20, pa.binary(WIDE))
    pq.write_table(pa.Table.from_arrays([column], ["wide"]), path, store_schema=False)


def columns(path):
    pq.write_table(pa.table({"id": ["a"]} | {f"c{k}": [0] for k in range(1500)}), path)


# What makes the file, the columns that are read, and what comes of it.
BOMBS = {
    "voxels": (lambda path: table(path, 5000, voxels=bytes(MEGABYTE)), SCHEMA, REFUSED),
    "names": (lambda path: table(path, 5000, "a" * MEGABYTE), SCHEMA, REFUSED),
    "texts": (lambda path: table(path, 300_000, "a" * 20_000), SCHEMA, REFUSED),
    "lying names": (lambda path: lying(path, 0, name="a" * MEGABYTE), SCHEMA, REFUSED),
    "lying voxels": (lambda path: lying(path, 1, voxels=b"a" * MEGABYTE), SCHEMA, REFUSED),
    "rows": (lambda path: rows(path, 60_000_000), SCHEMA.remove(2).remove(1), "60,000,000 rows"),
    "long": (lambda path: table(path, 40_000_000), SCHEMA, REFUSED),
    "columns": (columns, SCHEMA.remove(2).remove(1), "1,501 columns"),
    "categories": (categories, SCHEMA.remove(2).remove(1), REFUSED),
    "nested": (nested_categories, pa.schema([("id", pa.list_(pa.string()))]), "which is not read"),
    "beginnings": (shared_beginnings, SCHEMA.remove(2).remove(1), "100 rows"),
    "wide": (wide, pa.schema([("wide", pa.binary(WIDE))]), REFUSED),
}

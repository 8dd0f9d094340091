"""What the pages of a Parquet file say of themselves: the footer may say something else.

A reader takes memory by the headers of the pages. They are in Thrift's compact protocol; the
numbers below are those of `PageHeader` in parquet.thrift.
"""

import mmap
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pyarrow.parquet as pq

PADDING = 100  # bytes that readers grant to old files after the last page of a column
DIFFERENCES = 7  # the encoding DELTA_BYTE_ARRAY: texts that share their beginnings
_SIZE, _PACKED, _KINDS = 2, 3, (5, 7, 8)  # of a page; of data, a dictionary, data again
_VALUES, _ENCODINGS = 1, {5: 2, 7: 2, 8: 4}
_TRUE, _FALSE, _BYTE, _INTEGERS, _DOUBLE, _TEXT, _STRUCT = 1, 2, 3, (4, 5, 6), 7, 8, 12


class Page(NamedTuple):
    """One page of a column.

    Attributes:
        size: Bytes unpacked.
        values: How many values it has.
        encoding: Of these.
    """

    size: int
    values: int
    encoding: int


def pages(path: Path, chunk: pq.ColumnChunkMetaData) -> Iterator[Page]:
    """The pages of a part of a column, as far as a reader goes.

    Raises:
        ValueError: They are damaged.
    """
    start = chunk.data_page_offset
    if chunk.has_dictionary_page and 0 < chunk.dictionary_page_offset < start:
        start = chunk.dictionary_page_offset
    seen = 0
    with path.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
        end = min(start + chunk.total_compressed_size + PADDING, len(data))
        while seen < chunk.num_values and 0 <= start < end:
            header, start = _header(data, start)
            start += header[_PACKED]
            for kind in header.keys() & set(_KINDS):
                values = header[kind][_VALUES]
                if min(values, header[_SIZE], header[_PACKED]) < 0:
                    raise ValueError("a page of less than nothing")
                yield Page(header[_SIZE], values, header[kind][_ENCODINGS[kind]])
                seen += values if kind != 7 else 0


def _header(data: mmap.mmap, at: int) -> tuple[dict[int, Any], int]:
    try:
        return _struct(data, at)
    except (IndexError, KeyError, RecursionError) as error:
        raise ValueError("the header of a page is damaged") from error


def _struct(data: mmap.mmap, at: int) -> tuple[dict[int, Any], int]:
    """The fields of a struct by number, and where it ends."""
    fields: dict[int, Any] = {}
    number = 0
    while head := data[at]:
        at += 1
        if head >> 4:
            number += head >> 4
        else:
            number, at = _integer(data, at)
        fields[number], at = _value(data, at, head & 15)
    return fields, at + 1


def _value(data: mmap.mmap, at: int, kind: int) -> tuple[Any, int]:
    """A value, and where it ends; a page header has no lists."""
    if kind in (_TRUE, _FALSE):
        return kind == _TRUE, at
    if kind in _INTEGERS:
        return _integer(data, at)
    if kind == _STRUCT:
        return _struct(data, at)
    if kind in (_BYTE, _DOUBLE):
        return None, at + (1 if kind == _BYTE else 8)
    if kind == _TEXT:
        length, at = _varint(data, at)
        return None, at + length
    raise ValueError("the header of a page has fields of another kind")


def _integer(data: mmap.mmap, at: int) -> tuple[int, int]:
    value, at = _varint(data, at)
    return (value >> 1) ^ -(value & 1), at


def _varint(data: mmap.mmap, at: int) -> tuple[int, int]:
    value = 0
    for shift in range(0, 70, 7):
        value |= (data[at] & 127) << shift
        at += 1
        if data[at - 1] < 128:
            return value, at
    raise ValueError("a number in the header of a page is too long")

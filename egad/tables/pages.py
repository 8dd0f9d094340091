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
_DICTIONARY = 7
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
            page, is_data, start = _page(data, start)
            yield page
            seen += page.values if is_data else 0


def _page(data: mmap.mmap, at: int) -> tuple[Page, bool, int]:
    """A page, whether it is one of data, and where the next one begins."""
    try:
        header, at = _struct(data, at)
        kind = next(kind for kind in _KINDS if kind in header)
        page = Page(header[_SIZE], header[kind][_VALUES], header[kind][_ENCODINGS[kind]])
        end = at + header[_PACKED]
        damaged = min(page.size, page.values, header[_PACKED]) < 0
    except (IndexError, KeyError, StopIteration, RecursionError, TypeError) as error:
        raise ValueError("the header of a page is damaged") from error
    if damaged:
        raise ValueError("a page of less than nothing")
    return page, kind != _DICTIONARY, end


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

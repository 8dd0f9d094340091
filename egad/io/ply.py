"""PLY files, as text or in either byte order: polygons and strips of triangles."""

import re
import struct
from typing import NamedTuple

import numpy as np

from egad._util.arrays import Floats, Ints
from egad._util.input_limits import MAX_VERTICES, check_at_most
from egad.errors import RejectedError
from egad.io.polygons import Content, check_corners, strip_triangles, triangles_of
from egad.io.text import (
    BYTE_ORDER_MARK,
    check_digits,
    integers,
    is_padding,
    no_number,
    plain_text,
    reals,
)
from egad.io.units import stated_in_comments

ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
TYPES = {"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4"}
TYPES |= {"float": "f4", "double": "f8", "float32": "f4", "float64": "f8"}
TYPES |= {"int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4"}
UNREAD = ("trifans", "range_grid")
INDICES = ("vertex_indices", "vertex_index")
_END = re.compile(rb"\nend_header[ \t]*\n|\rend_header[ \t]*\r\n?|\nend_header[ \t]*\r\n")


class Property(NamedTuple):
    """A property of an element: its NumPy type, and that of its length if it is a list."""

    name: str
    kind: str
    length: str = ""


class Element(NamedTuple):
    """An element of the header: its name, how many of it there are, and their properties."""

    name: str
    size: int
    properties: list[Property]

    @property
    def has_lists(self) -> bool:
        """Whether rows may differ in length."""
        return any(each.length for each in self.properties)


class ElementRows(NamedTuple):
    """The numbers of an element that are used."""

    points: Floats  # coordinates of vertices, (n, 3); empty for other elements
    items: Ints  # the values of all lists of indices, one after the other
    lengths: Ints  # lengths of these lists


NOTHING = ElementRows(np.empty((0, 3)), np.empty(0, np.int64), np.empty(0, np.int64))


def parse_ply(data: bytes) -> Content:
    """Read a PLY file without other elements and properties, or raise `RejectedError`."""
    data = data.removeprefix(BYTE_ORDER_MARK)
    if not data.startswith(b"ply"):
        plain_text(data)  # says so if it is UTF-16
        raise RejectedError("it does not start with `ply`")
    end = _END.search(data)
    if end is None:
        raise RejectedError("its header does not end")
    header = plain_text(data[: end.start()]).decode("latin-1").split("\n")
    order, elements = _elements(header)
    read = _text_rows if order == "" else _binary_rows
    rows = read(data[end.end() :], elements, order)
    vertices = rows.get("vertex", NOTHING).points
    faces = rows.get("face", NOTHING)
    parts = [triangles_of(vertices, faces.items, faces.lengths)]
    parts += _strips(rows.get("tristrips", NOTHING), len(vertices))
    return Content(vertices, np.concatenate(parts), stated_in_comments(data[: end.start()]))


def _strips(rows: ElementRows, count: int) -> list[Ints]:
    """Triangles of strips, which -1 separates within a list."""
    lists = np.split(rows.items, np.cumsum(rows.lengths)[:-1])
    cuts = [np.split(each, np.flatnonzero(each == -1)) for each in lists]
    strips = [strip[strip != -1] for strips in cuts for strip in strips]
    check_corners(np.concatenate(strips) if strips else rows.items, count)
    return [strip_triangles(strip) for strip in strips if len(strip) >= 3]


def _elements(lines: list[str]) -> tuple[str, list[Element]]:
    """The byte order and the elements of a header."""
    order, elements = None, list[Element]()
    for line in lines[1:]:
        match line.split():
            case ["format", kind, version]:
                order = _order(kind, version)
            case ["element", name, count] if count.isdecimal():
                elements.append(Element(name, int(count), []))
            case ["property", "list", length, kind, name] if elements:
                elements[-1].properties.append(Property(name, _type(kind), _type(length)))
            case ["property", kind, name] if elements:
                elements[-1].properties.append(Property(name, _type(kind)))
            case [] | ["comment" | "obj_info", *_]:
                pass
            case _:
                raise RejectedError(f"its header has the unknown line {line[:40]!r}")
    if order is None:
        raise RejectedError("its header does not say the format")
    for each in elements:
        _check(each)
    return order, elements


def _order(kind: str, version: str) -> str:
    if kind not in ORDERS or version != "1.0":
        raise RejectedError(f"the format {kind} {version} is not supported")
    return ORDERS[kind]


def _check(element: Element) -> None:
    if element.name == "vertex":
        if not {"x", "y", "z"} <= {one.name for one in element.properties if not one.length}:
            raise RejectedError("its vertices do not have the properties x, y and z")
        check_at_most(element.size, MAX_VERTICES, "vertices")
    if element.name in UNREAD and element.size:
        raise RejectedError(f"its element {element.name} is not supported; export triangles")
    if element.name == "face" and element.size and _used(element) is None:
        raise RejectedError(f"its faces do not have a list {' or '.join(INDICES)}")


def _type(name: str) -> str:
    if name not in TYPES:
        raise RejectedError(f"its header has the unknown type {name!r}")
    return TYPES[name]


def _used(element: Element) -> int | None:
    """The place of the list of indices among the properties of an element."""
    places = [k for k, one in enumerate(element.properties) if one.length and one.name in INDICES]
    return places[0] if places else None


def _cut_short(element: Element) -> RejectedError:
    return RejectedError(
        f"it is truncated: some of its {element.size:,} {element.name} elements are missing"
    )


def _text_rows(data: bytes, elements: list[Element], _order: str) -> dict[str, ElementRows]:
    words, place, found = plain_text(data).split(), 0, {}
    for element in elements:
        if len(words) - place < element.size * len(element.properties):
            raise _cut_short(element)
        if element.has_lists:
            found[element.name], place = _text_lists(words, place, element)
        else:
            end = place + element.size * len(element.properties)
            found[element.name] = _points(words[place:end], element)
            place = end
    if place < len(words):
        raise RejectedError("it holds more numbers than its header says")
    return found


def _points(words: list[bytes], element: Element) -> ElementRows:
    """The coordinates of vertices, which have one word for each property."""
    if element.name != "vertex":
        return NOTHING
    names, width = [one.name for one in element.properties], len(element.properties)
    columns = [_column(words[names.index(axis) :: width], element, axis) for axis in "xyz"]
    return NOTHING._replace(points=np.column_stack(columns))


def _column(words: list[bytes], element: Element, axis: str) -> Floats:
    """Coordinates as numbers of the type that the header gives them."""
    kind = next(np.dtype(one.kind) for one in element.properties if one.name == axis)
    values = reals(words, "a vertex")
    if kind.kind == "f":
        return values.astype(kind).astype(np.float64)
    limits = np.iinfo(kind)
    wrong = (values != np.round(values)) | (values < limits.min) | (values > limits.max)
    if wrong.any():
        raise RejectedError(
            f"a vertex: {values[wrong.argmax()]:g} is not of the type {kind.name} of {axis}"
        )
    return values


def _text_lists(words: list[bytes], place: int, element: Element) -> tuple[ElementRows, int]:
    """The rows of an element with lists, and where they end."""
    used, singles = _used(element), list[bytes]()
    items, lengths = list[bytes](), list[int]()
    for _ in range(element.size):
        for number, one in enumerate(element.properties):
            if place >= len(words):
                raise _cut_short(element)
            if not one.length:
                singles.append(words[place])
                place += 1
                continue
            count = _length(words[place], element)
            part = words[place + 1 : place + 1 + count]
            if len(part) < count:
                raise _cut_short(element)
            if number == used:
                items += part
                lengths.append(count)
            place += 1 + count
    kept = element._replace(properties=[one for one in element.properties if not one.length])
    points = _points(singles, kept).points
    values = integers(items, f"an index of {element.name}")
    return ElementRows(points, values, np.array(lengths, np.int64)), place


def _length(word: bytes, element: Element) -> int:
    """The length of a list, which is not negative."""
    try:
        check_digits([word])
        count = int(word)
    except ValueError:
        no_number([word], f"the length of a list of {element.name}", int)
    if count < 0:
        raise RejectedError(f"a list of {element.name} has a negative length")
    return count


def _binary_rows(data: bytes, elements: list[Element], order: str) -> dict[str, ElementRows]:
    place, found = 0, {}
    for element in elements:
        kind = _row_type(data, place, element, order)
        if kind is not None and len(data) - place >= kind.itemsize * element.size:
            rows = np.frombuffer(data, kind, element.size, place)
            lists = [f"length{k}" for k, one in enumerate(element.properties) if one.length]
            if all((rows[name] == rows[name][:1]).all() for name in lists):
                found[element.name] = _columns(rows, element)
                place += rows.nbytes
                continue
        if not element.has_lists:
            raise _cut_short(element)
        found[element.name], place = _binary_lists(data, place, element, order)
    if not is_padding(data[place:]):
        raise RejectedError("it holds more than its header says")
    return found


def _row_type(data: bytes, place: int, element: Element, order: str) -> np.dtype | None:
    """The type of the first row; None if the row is not whole."""
    fields: list[tuple[str, str] | tuple[str, str, int]] = []
    size = 0
    for number, one in enumerate(element.properties):
        if one.length:
            length = np.dtype(order + one.length)
            if element.size and place + size + length.itemsize > len(data):
                return None
            count = int(np.frombuffer(data, length, 1, place + size)[0]) if element.size else 0
            if count < 0 or count > len(data):
                return None
            fields.append((f"length{number}", order + one.length))
            fields.append((f"value{number}", order + one.kind, count))
        else:
            fields.append((f"value{number}", order + one.kind))
        size = np.dtype(fields).itemsize
    return np.dtype(fields)


def _columns(rows: np.ndarray, element: Element) -> ElementRows:
    """The used numbers of rows that are all alike."""
    found, used = NOTHING, _used(element)
    names = [one.name for one in element.properties]
    if element.name == "vertex":
        columns = [rows[f"value{names.index(axis)}"] for axis in "xyz"]
        found = found._replace(points=np.column_stack(columns).astype(np.float64))
    if used is not None:
        items = rows[f"value{used}"].astype(np.int64)
        lengths = rows[f"length{used}"].astype(np.int64)
        found = found._replace(items=items.ravel(), lengths=lengths)
    return found


def _binary_lists(data: bytes, place: int, element: Element, order: str) -> tuple[ElementRows, int]:
    """The rows of an element with lists of different lengths, and where they end."""
    used, names = _used(element), [one.name for one in element.properties]
    axes = [names.index(axis) for axis in "xyz"] if element.name == "vertex" else []
    single = {kind: struct.Struct(order + np.dtype(kind).char) for kind in TYPES.values()}
    points, items, lengths = list[float](), list[Ints](), list[int]()
    try:
        for _ in range(element.size):
            values = dict[int, float]()
            for number, one in enumerate(element.properties):
                packed = single[one.length or one.kind]
                (value,) = packed.unpack_from(data, place)
                place += packed.size
                if not one.length:
                    values[number] = value
                    continue
                if value < 0:
                    raise RejectedError(f"a list of {element.name} has a negative length")
                if number == used:
                    items.append(np.frombuffer(data, order + one.kind, value, place))
                    lengths.append(value)
                place += value * np.dtype(one.kind).itemsize
            points += [values[axis] for axis in axes]
    except (struct.error, ValueError):
        raise _cut_short(element) from None
    if place > len(data):
        raise _cut_short(element)
    together = np.concatenate(items).astype(np.int64) if items else NOTHING.items
    return ElementRows(
        np.array(points).reshape(-1, 3), together, np.array(lengths, np.int64)
    ), place

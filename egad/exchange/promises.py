"""What a mesh file promises, checked before memory is taken for it.

Files of strangers may promise more than they hold, or little that unfolds to much: a header with
10^9 faces, a zip of zeros, parts made of parts. They may also name other files. None of this is
read; the message says which bound was passed.
"""

import re

import numpy as np
from numpy.typing import NDArray

from egad.errors import RejectedError
from egad.exchange.bounds import MOST_CORNERS, MOST_ITEMS, MOST_PARTS, within
from egad.exchange.promises_3mf import check_3mf
from egad.exchange.promises_glb import check_glb

_PLY_WORDS = {b"ply", b"format", b"comment", b"obj_info", b"element", b"property"}
_PLY_BYTES = dict.fromkeys((b"char", b"uchar", b"int8", b"uint8"), 1)
_PLY_BYTES |= dict.fromkeys((b"short", b"ushort", b"int16", b"uint16"), 2)
_PLY_BYTES |= dict.fromkeys((b"int", b"uint", b"float", b"int32", b"uint32", b"float32"), 4)
_PLY_BYTES |= dict.fromkeys((b"double", b"float64"), 8)


def check_promises(data: bytes, ending: str) -> None:
    """Look through a file for what would take more memory than it may.

    Args:
        data: Its content, at most `MOST_BYTES`.
        ending: Of its name: stl, ply, off, obj, glb or 3mf.

    Raises:
        RejectedError: It promises too much, or names other files.
        Exception: It is damaged; anything may be raised.
    """
    {
        "stl": _check_stl,
        "ply": _check_ply,
        "off": _check_off,
        "obj": _check_obj,
        "glb": check_glb,
        "3mf": check_3mf,
    }[ending](data)


def only_geometry(data: bytes) -> bytes:
    """An OBJ file with nothing but vertices and faces, and in these no more than the vertices.

    Materials, groups and comments would make parts that share all vertices, and name other files.

    Raises:
        RejectedError: These are too many, or a polygon has too many corners.
    """
    lines = data.replace(b"\r\n", b"\n").replace(b"\\\n", b"")
    lines = re.sub(rb"^[ \t]+", b"", lines, flags=re.MULTILINE)
    text = np.frombuffer(lines + b"\n", np.uint8)
    ends = np.flatnonzero(text == ord("\n"))
    starts = np.concatenate(([0], ends[:-1] + 1))
    after = np.minimum(starts + 1, len(text) - 1)
    geometry = np.isin(text[starts], (ord("v"), ord("f"))) & np.isin(text[after], (9, 32))
    kept = text[np.repeat(geometry, ends + 1 - starts)].tobytes()
    kept = re.sub(rb"/[^\s]*", b"", kept.replace(b"\t", b" "))
    _check_geometry(kept)
    return kept


def _check_stl(data: bytes) -> None:
    if len(data) >= 84 and 84 + 50 * int.from_bytes(data[80:84], "little") == len(data):
        within(int.from_bytes(data[80:84], "little"), MOST_ITEMS, "faces")
        return
    _words_by_line(data, 24 * MOST_ITEMS)
    text = data.lower()
    within(text.count(b"vertex") / 3, MOST_ITEMS, "faces")
    within(text.count(b"endsolid"), MOST_PARTS, "bodies")


def _check_ply(data: bytes) -> None:
    head, size = _ply_header(data)
    fixed, narrowest, count = 0, 8, 0
    for line in head:
        match line:
            case [b"element", name, number]:
                count = int(number)
                within(count, MOST_ITEMS, f"elements called {name.decode()}")
            case [b"property", b"list", _, kind, _]:
                narrowest = min(narrowest, _PLY_BYTES[kind])
            case [b"property", kind, _]:
                fixed += count * _PLY_BYTES[kind]
    if b"ascii" in head[1]:
        _check_polygons(data[size:], 20 * MOST_ITEMS)
    elif len(data) - size > fixed:
        within((len(data) - size - fixed) / narrowest, 12 * MOST_ITEMS, "values in lists")


def _ply_header(data: bytes) -> tuple[list[list[bytes]], int]:
    """The words of each line of a header, and its length in bytes."""
    words, size = [], 0
    for line in data[:100_000].split(b"\n"):
        size += len(line) + 1
        if b"end_header" in line.split():
            break
        words.append(line.split())
    else:
        raise RejectedError("its header has no end")
    if not {line[0] for line in words if line} <= _PLY_WORDS:
        raise RejectedError("its header has a line of another kind")
    return words, size


def _check_off(data: bytes) -> None:
    lines = data.count(b"\n") + data.count(b"\r")
    counts = re.match(rb"\s*C?OFF\s+(\d+)\s+(\d+)", re.sub(rb"#[^\n]*", b"", data[:100_000]))
    if counts and int(counts[1]) + int(counts[2]) > lines:
        raise RejectedError("it is cut short")
    _check_polygons(data, 10 * MOST_ITEMS)


def _check_obj(data: bytes) -> None:
    within(data.count(b"\n"), 4 * MOST_ITEMS, "lines")
    _check_lines(data)


def _check_lines(data: bytes) -> None:
    """The vertices and faces of an OBJ file."""
    for letter, what in ((b"v", "vertices"), (b"f", "faces")):
        starts = (letter + b" ", letter + b"\t")
        count = sum(data.count(b"\n" + start) for start in starts) + data.startswith(starts)
        within(count, MOST_ITEMS, what)


def _check_geometry(kept: bytes) -> None:
    """The lines of an OBJ file that has only vertices and faces."""
    _check_lines(kept)
    words = _words_by_line(kept, 16 * MOST_ITEMS) - 1
    starts = np.concatenate(([0], np.flatnonzero(np.frombuffer(kept, np.uint8) == ord("\n")) + 1))
    starts = starts[starts < len(kept)]
    corners = words[: len(starts)][np.frombuffer(kept, np.uint8)[starts] == ord("f")]
    within(corners.max(initial=0), MOST_CORNERS, "corners of a face")
    within(np.maximum(corners - 2, 0).sum(), MOST_ITEMS, "triangles")


def _check_polygons(data: bytes, most: int) -> None:
    """The lines of other text, in which each face has one."""
    lines = data.replace(b"\r", b"\n")
    within(lines.count(b"\n"), 2 * MOST_ITEMS, "lines")
    within(_words_by_line(lines, most).max(initial=0), MOST_CORNERS, "words in a line")


def _words_by_line(data: bytes, most: int) -> NDArray[np.int64]:
    """How many words each line has; whatever is no ASCII letter, digit or sign parts words.

    Raises:
        RejectedError: There are too many of them.
    """
    text = np.frombuffer(data, np.uint8)
    inside = np.zeros(len(text) + 1, bool)
    np.greater(text, ord(" "), out=inside[1:])
    inside[1:] &= text < 127
    begun = inside[1:] > inside[:-1]
    within(int(np.count_nonzero(begun)), most, "words")
    ends = np.flatnonzero(text == ord("\n"))
    bounds = np.concatenate(([0], ends, [len(text)]))
    return np.diff(np.searchsorted(np.flatnonzero(begun), bounds))

"""OFF files, as Geomview defines them: with colors, normals and texture coordinates or without."""

import re

import numpy as np

from egad._util.input_limits import MAX_VERTICES, check_at_most
from egad.errors import RejectedError
from egad.io.content import Content
from egad.io.polygons import triangles_of
from egad.io.text import integers, plain_text, reals
from egad.io.units import COMMENTS, stated_in

_HEADER = re.compile(rb"\s*((?:ST)?C?N?)(4?)(n?)OFF(?![A-Za-z])\s*(BINARY)?")
_COMMENTS = re.compile(rb"#[^\n]*")


def parse_off(data: bytes) -> Content:
    """Read an OFF file. Colors, normals and texture coordinates are left out.

    Raises:
        RejectedError: It is binary, has coordinates of more dimensions, is truncated, or holds more
            than its header says.
    """
    text = plain_text(data)
    unit = stated_in(b" ".join(_COMMENTS.findall(text[:COMMENTS])))
    rows = [row for line in _body(_COMMENTS.sub(b"", text)).split(b"\n") if (row := line.split())]
    sizes = integers(rows[0][:2], "the counts").tolist() if rows else []
    if len(sizes) < 2 or min(sizes) < 0:
        raise RejectedError("the numbers of vertices and faces are missing")
    count, polygons = sizes
    if len(rows) - 1 < count + polygons:
        raise RejectedError(
            f"it is truncated: {count:,} vertices and {polygons:,} faces are announced, each on a "
            f"line of its own, but {len(rows) - 1:,} lines follow"
        )
    if len(rows) - 1 > count + polygons:
        raise RejectedError(f"more lines follow than its {count:,} vertices and {polygons:,} faces")
    check_at_most(count, MAX_VERTICES, "vertices")
    points = [row[:3] for row in rows[1 : 1 + count]]
    if any(len(point) < 3 for point in points):
        raise RejectedError("a vertex has fewer than 3 coordinates")
    vertices = reals([word for point in points for word in point], "a vertex").reshape(-1, 3)
    return Content(vertices, _faces(vertices, rows[1 + count :]), unit)


def _body(text: bytes) -> bytes:
    """What follows the header, which may be missing."""
    header = _HEADER.match(text)
    if header is None:
        if re.match(rb"\s*\d", text):
            return text
        raise RejectedError("it does not start with OFF")
    _, homogeneous, dimensions, binary = header.groups()
    if binary:
        raise RejectedError("binary OFF is not read; save it as text")
    if homogeneous or dimensions:
        kind = (homogeneous + dimensions).decode()
        raise RejectedError(f"{kind}OFF, coordinates of other dimensions than 3, is not read")
    return text[header.end() :]


def _faces(vertices: np.ndarray, rows: list[list[bytes]]) -> np.ndarray:
    """Triangles of the lines of polygons; what follows their corners is a color."""
    lengths = integers([row[0] for row in rows], "a face")
    polygons = [row[1 : 1 + length] for row, length in zip(rows, lengths.tolist(), strict=True)]
    for polygon, length in zip(polygons, lengths.tolist(), strict=True):
        if len(polygon) != length:
            raise RejectedError(
                f"it is truncated: a face of {length} corners has only {len(polygon)}"
            )
    corners = integers([word for polygon in polygons for word in polygon], "a face")
    return triangles_of(vertices, corners, lengths)

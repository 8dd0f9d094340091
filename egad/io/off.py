"""OFF files, as Geomview defines them: with colors, normals and texture coordinates or without."""

import re

import numpy as np

from egad._util.input_limits import MAX_VERTICES, check_at_most
from egad.errors import RejectedError
from egad.io.polygons import Content, triangles_of
from egad.io.text import integers, plain_text, reals
from egad.io.units import stated_in_comments

_HEADER = re.compile(rb"\s*((?:ST)?C?N?)(4?)(n?)OFF(?![A-Za-z])\s*(BINARY)?")
_COMMENTS = re.compile(rb"#[^\n]*")


def parse_off(data: bytes) -> Content:
    """Read an OFF file without colors, normals and texture points, or raise `RejectedError`."""
    text = plain_text(data)
    kind, body = _body(_COMMENTS.sub(b"", text))
    words = body.split()
    sizes = integers(words[:2], "the counts").tolist()
    if len(sizes) < 2 or min(sizes) < 0:
        raise RejectedError("the numbers of vertices and faces are missing")
    count, polygons = sizes
    rows = [row for line in body.split(b"\n") if (row := line.split())][1:]
    if len(rows) != count + polygons:
        free = None if kind else _free_rows(words[3:], count, polygons)
        if free is None:
            raise RejectedError(
                f"it is truncated, or does not have one vertex or face per line: it announces "
                f"{count:,} vertices and {polygons:,} faces, but {len(rows):,} lines follow"
            )
        rows = free
    check_at_most(count, MAX_VERTICES, "vertices")
    points = [row[:3] for row in rows[:count]]
    if any(len(point) < 3 for point in points):
        raise RejectedError("a vertex has fewer than 3 coordinates")
    vertices = reals([word for point in points for word in point], "a vertex").reshape(-1, 3)
    return Content(vertices, _faces(vertices, rows[count:]), stated_in_comments(data))


def _free_rows(words: list[bytes], count: int, polygons: int) -> list[list[bytes]] | None:
    """Vertices and faces without colors, as words on any lines; None if they do not fit."""
    rows = [words[3 * k : 3 * k + 3] for k in range(min(count, len(words)))]
    place = 3 * count
    for _ in range(polygons):
        if place >= len(words) or not words[place].isdigit():
            return None
        end = place + 1 + int(words[place])
        rows.append(words[place:end])
        place = end
    return rows if place == len(words) else None


def _body(text: bytes) -> tuple[bytes, bytes]:
    """What the header, which may be missing, says about vertices; and what follows it."""
    header = _HEADER.match(text)
    if header is None:
        if re.match(rb"\s*\d", text):
            return b"", text
        raise RejectedError("it does not start with OFF")
    more, homogeneous, dimensions, binary = header.groups()
    if binary:
        raise RejectedError("binary OFF is not supported; save it as text")
    if homogeneous or dimensions:
        kind = (homogeneous + dimensions).decode()
        raise RejectedError(f"{kind}OFF, with coordinates that are not 3D, is not supported")
    return more, text[header.end() :]


def _faces(vertices: np.ndarray, rows: list[list[bytes]]) -> np.ndarray:
    """Triangles of the lines of polygons; what follows their corners is a color."""
    lengths = integers([row[0] for row in rows], "a face")
    polygons = [row[1 : 1 + length] for row, length in zip(rows, lengths.tolist(), strict=True)]
    for polygon, length in zip(polygons, lengths.tolist(), strict=True):
        if length < 0:
            raise RejectedError(f"a face has {length} corners")
        if len(polygon) != length:
            raise RejectedError(
                f"it is truncated: a face of {length} corners has only {len(polygon)}"
            )
    corners = integers([word for polygon in polygons for word in polygon], "a face")
    return triangles_of(vertices, corners, lengths)

"""Wavefront OBJ files of nothing but triangles: what this program writes, and reads in no time."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def obj_text(vertices: Floats, faces: Ints) -> str:
    """An OBJ file, with enough digits to read it back.

    Args:
        vertices: (n, 3).
        faces: (m, 3) vertex indices.
    """
    points = "v %r %r %r\n" * len(vertices) % tuple(vertices.ravel().tolist())
    return points + "f %d %d %d\n" * len(faces) % tuple((faces + 1).ravel().tolist())


def parse_plain_obj(data: bytes) -> tuple[Floats, Ints] | None:
    """Vertices (n, 3) and faces (m, 3) of a file that has lines as `obj_text` writes them.

    Returns:
        None for a file with anything else in it: comments, normals, polygons, blank lines.
    """
    middle = data.find(b"\nf ") + 1
    vertices = _numbers(data[:middle], b"v ", b"+-.e", np.float64)
    faces = _numbers(data[middle:], b"f ", b"", np.int64)
    return None if vertices is None or faces is None else (vertices, faces - 1)


def _numbers(lines: bytes, start: bytes, also: bytes, kind: type) -> NDArray[Any] | None:
    """The numbers of lines of three after the same start, (n, 3); None if they are not so."""
    text = np.frombuffer(lines, np.uint8)
    ends, spaces = np.flatnonzero(text == ord("\n")), np.flatnonzero(text == ord(" "))
    count = len(ends)
    if count == 0 or ends[-1] != len(lines) - 1 or len(spaces) != 3 * count:
        return None
    starts = np.concatenate(([0], ends[:-1] + 1))
    begun = (text[starts] == start[0]) & (spaces[::3] == starts + 1)
    inside = spaces[2::3] < ends
    if not (begun & inside).all() or lines.translate(None, b"0123456789 \n" + also + start):
        return None
    bare = lines.replace(start, b"")
    if start[:1] in bare:
        return None
    try:
        values: NDArray[Any] = np.fromstring(bare, dtype=kind, sep=" ")
    except ValueError:
        return None
    return values.reshape(-1, 3) if len(values) == 3 * count else None

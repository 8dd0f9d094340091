"""STL files, binary and ASCII."""

import re
from pathlib import Path

import numpy as np
import trimesh

from egad._util.arrays import Floats
from egad._util.files import atomic_output
from egad._util.input_limits import MAX_FACES, check_at_most
from egad.errors import RejectedError
from egad.io.polygons import Content
from egad.io.text import BYTE_ORDER_MARK, START, is_padding, is_utf16, plain_text, reals
from egad.io.units import stated_in

HEADER, FACET = 84, 50  # bytes
_NAMES = re.compile(rb"^[ \t]*(?:end)?solid\b[^\n]*", re.MULTILINE | re.IGNORECASE)
_FLOATS = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def parse_stl(data: bytes) -> Content:
    """Read an STL file of either kind, or raise `RejectedError`; faces share no vertices."""
    if not data:
        raise RejectedError("it is empty")
    count = int.from_bytes(data[80:HEADER], "little")
    if len(data) != HEADER + FACET * count and _is_text(data):
        return _parse_ascii(plain_text(data))
    return parse_binary(data)


def count_binary_faces(path: Path) -> int | None:
    """Number of faces of a binary STL file that is as long as its header says, else None."""
    with path.open("rb") as file:
        count = int.from_bytes(file.read(HEADER)[80:], "little")
    return count if path.stat().st_size == HEADER + FACET * count else None


def _is_text(data: bytes) -> bool:
    """Whether a file is text; refuses text that does not start as ASCII files do."""
    start = data[:START]
    if is_utf16(start):
        return True  # which is refused by name
    if 0 in start:
        return False
    words = start.removeprefix(BYTE_ORDER_MARK).lower().split(None, 1)
    if words[:1] != [b"solid"]:
        raise RejectedError("it is neither a binary file nor text that starts with `solid`")
    return True


def parse_binary(data: bytes) -> Content:
    """Read a binary STL file. Programs that do not know the count yet write 0."""
    if len(data) < HEADER:
        raise RejectedError("it is truncated: its header is incomplete")
    count, there = int.from_bytes(data[80:HEADER], "little"), (len(data) - HEADER) // FACET
    if there < count:
        raise RejectedError(f"it is truncated: its header says {count:,} faces, it has {there:,}")
    if count == 0:
        count = there
        if not is_padding(data[HEADER + FACET * count :]):
            raise RejectedError(f"it is truncated within face {count + 1:,}")
    elif there > count and not is_padding(data[HEADER + FACET * count :]):
        raise RejectedError(f"its header says {count:,} faces, but the file holds {there:,}")
    check_at_most(count, MAX_FACES, "faces")
    corners = np.frombuffer(data, _FLOATS, count, HEADER)["corners"]
    return _separate(corners.reshape(-1, 3).astype(np.float64), stated_in_header(data))


def stated_in_header(data: bytes) -> str | None:
    """The unit that a file states: at the start, which is the header or the name of a solid."""
    return stated_in(data[:80])


def _separate(vertices: Floats, unit: str | None) -> Content:
    return Content(vertices, np.arange(len(vertices)).reshape(-1, 3), unit)


def _parse_ascii(text: bytes) -> Content:
    words = np.array(_NAMES.sub(b"", text).lower().split(), dtype="S")
    starts, ends = np.flatnonzero(words == b"facet"), np.flatnonzero(words == b"endfacet")
    corners = np.flatnonzero(words == b"vertex")
    if len(starts) != len(ends):
        raise RejectedError(f"it is truncated: {len(starts)} facets begin, {len(ends)} end")
    inside = np.searchsorted(corners, ends) - np.searchsorted(corners, starts)
    if (inside != 3).any() or len(corners) != 3 * len(starts):
        raise RejectedError("a facet does not have 3 corners")
    numbers = words[np.minimum(corners[:, None] + [1, 2, 3], len(words) - 1)].ravel()
    return _separate(reals(numbers.tolist(), "a vertex").reshape(-1, 3), stated_in_header(text))


def write_stl_mm(mesh: trimesh.Trimesh, path: Path) -> None:
    """Write a binary STL file in millimetres, of a mesh in metres; its header says so."""
    facets = np.zeros(len(mesh.faces), _FLOATS)
    facets["normal"] = mesh.face_normals
    facets["corners"] = mesh.triangles * 1000
    header = b"egad, unit: millimetre".ljust(80)
    with atomic_output(path) as temporary:
        temporary.write_bytes(header + np.uint32(len(facets)).tobytes() + facets.tobytes())

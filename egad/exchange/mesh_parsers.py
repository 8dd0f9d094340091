"""Vertices and faces of mesh files, by trimesh; nothing but the bytes of the file is read."""

import io
import re
import zipfile
from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray

from egad._util.input_limits import MAX_FACES, MAX_UNPACKED_BYTES, MAX_VERTICES, check_at_most
from egad.errors import RejectedError

Arrays = tuple[NDArray[np.float64], NDArray[np.int64]]


def parse_file(path: Path) -> Arrays:
    """Read a file, see `parse`."""
    return parse(path.read_bytes(), path.suffix[1:].lower())


def parse(data: bytes, ending: str) -> Arrays:
    """Vertices (n, 3) and faces (m, 3) of a mesh file.

    Args:
        data: Its content. It may unfold to any amount of memory, unless it is a binary STL file.
        ending: Of its name: stl, ply, off, obj, glb or 3mf.

    Raises:
        RejectedError: It has more vertices or faces than are read, or is cut short.
        Exception: It is damaged; anything may be raised.
    """
    if ending == "obj":
        data = only_geometry(data)
    elif ending == "off":
        _check_length(data)
    elif ending == "3mf":
        _check_unpacked(data)
    options = {"process": False, "maintain_order": True, "skip_materials": True}
    with np.errstate(all="ignore"):
        found = trimesh.load_mesh(io.BytesIO(data), ending, **options)
    vertices = np.asarray(found.vertices, dtype=np.float64).reshape(-1, 3)
    faces = np.asarray(found.faces, dtype=np.int64).reshape(-1, 3)
    # Each face of an STL file has three vertices of its own.
    check_at_most(len(vertices), (3 if ending == "stl" else 1) * MAX_VERTICES, "vertices")
    check_at_most(len(faces), MAX_FACES, "faces")
    return vertices, faces


def only_geometry(data: bytes) -> bytes:
    """An OBJ file with nothing but vertices and faces, and in these no more than the vertices.

    Materials and groups would make parts that share all vertices.
    """
    lines = data.replace(b"\r\n", b"\n").replace(b"\\\n", b"")
    kept = re.findall(rb"^[ \t]*([vf][ \t][^\n]*)", lines, re.MULTILINE)
    return re.sub(rb"/[^\s]*", b"", b"\n".join(kept).replace(b"\t", b" ")) + b"\n"


def _check_length(data: bytes) -> None:
    """Refuse an OFF file with fewer lines than elements: trimesh reads as far as it goes."""
    lines = data.count(b"\n") + data.count(b"\r")
    counts = re.match(rb"\s*C?OFF\s+(\d+)\s+(\d+)", re.sub(rb"#[^\n]*", b"", data[:100_000]))
    if counts and int(counts[1]) + int(counts[2]) > lines:
        raise RejectedError("it is truncated")


def _check_unpacked(data: bytes) -> None:
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        size = sum(entry.file_size for entry in archive.infolist())
    check_at_most(size, MAX_UNPACKED_BYTES, "bytes unpacked")

"""Wavefront OBJ files with only triangles, which this program writes, and reads quickly."""

from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import trimesh
from numpy.typing import NDArray
from pyarrow import csv

from egad._util.arrays import Floats, Ints
from egad._util.files import atomic_output
from egad._util.input_limits import MAX_FACES, MAX_VERTICES, check_at_most
from egad.io.polygons import check_corners


def write_obj(mesh: trimesh.Trimesh, path: Path) -> None:
    """Write a Wavefront OBJ file in the unit of the mesh, with enough digits to read it back."""
    text = obj_text(np.asarray(mesh.vertices), np.asarray(mesh.faces))
    with atomic_output(path) as temporary:
        temporary.write_text(text, encoding="ascii")


def obj_text(vertices: Floats, faces: Ints) -> str:
    """An OBJ file of vertices (n, 3) and faces (m, 3), with enough digits to read it back."""
    points = "v %s %s %s\n" * len(vertices) % tuple(_texts(vertices.ravel()))
    return points + "f %d %d %d\n" * len(faces) % tuple((faces + 1).ravel().tolist())


def _texts(values: Floats) -> list[str]:
    """Numbers as `repr` writes them. Arrow is faster, and writes the same for usual sizes."""
    size = np.abs(values)  # Arrow writes exponents and whole numbers differently
    alike = (size >= 1e-4) & (size < 1e6) & (values != np.floor(values))
    texts = pa.array(values).cast(pa.string())
    others = pa.array([repr(value) for value in values[~alike].tolist()], pa.string())
    found: list[str] = pc.replace_with_mask(texts, ~alike, others).to_pylist()
    return found


def parse_plain_obj(data: bytes) -> tuple[Floats, Ints] | None:
    """Vertices (n, 3), faces (m, 3) of a file with lines as `obj_text` writes; None for others."""
    check_at_most(data.count(b"\nv ") + data.startswith(b"v "), MAX_VERTICES, "vertices")
    check_at_most(data.count(b"\nf "), MAX_FACES, "faces")
    middle = data.find(b"\nf ") + 1
    vertices = _numbers(data[:middle], b"v ", b"+-.e", np.float64)
    faces = _numbers(data[middle:], b"f ", b"", np.int64)
    if vertices is None or faces is None:
        return None
    check_corners(faces - 1, len(vertices))
    return vertices, faces - 1


def _numbers(lines: bytes, start: bytes, also: bytes, kind: type) -> NDArray[Any] | None:
    """The three numbers of each line after the same start, (n, 3); None if some line differs."""
    text = np.frombuffer(lines, np.uint8)
    ends, spaces = np.flatnonzero(text == ord("\n")), np.flatnonzero(text == ord(" "))
    count = len(ends)
    if count == 0 or ends[-1] != len(lines) - 1 or len(spaces) != 3 * count:
        return None
    starts = np.concatenate(([0], ends[:-1] + 1))
    prefixed = (text[starts] == start[0]) & (spaces[::3] == starts + 1)
    inside = spaces[2::3] < ends
    if not (prefixed & inside).all() or lines.translate(None, b"0123456789 \n" + also + start):
        return None
    bare = lines.replace(start, b"")
    if start[:1] in bare:
        return None
    try:
        values = _decimals(lines) if kind is np.float64 else np.fromstring(bare, kind, sep=" ")
    except ValueError:
        return None
    return values.reshape(-1, 3) if values.size == 3 * count else None


def _decimals(lines: bytes) -> Floats:
    """The numbers of lines of a letter and three numbers, (n, 3); a ValueError if one is none."""
    names = ["x", "y", "z"]
    table = csv.read_csv(
        pa.BufferReader(lines),
        csv.ReadOptions(use_threads=False, block_size=len(lines), column_names=["", *names]),
        csv.ParseOptions(delimiter=" ", quote_char=False),
        csv.ConvertOptions(
            column_types=dict.fromkeys(names, pa.float64()), include_columns=names, null_values=[]
        ),
    )
    return np.column_stack([column.to_numpy() for column in table.columns])

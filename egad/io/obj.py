"""Wavefront OBJ files of any program: one mesh of all objects, groups and materials.

Files with only triangles, which this program writes, are read quickly.
"""

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
from egad.errors import RejectedError
from egad.io.polygons import Content, check_corners, triangles_of
from egad.io.text import check_digits, no_number, plain_text
from egad.io.units import stated_in_comments

# Shapes that triangles cannot represent; lines and points of the format have no surface.
REFUSED = {
    b"curv": "a free-form curve",
    b"surf": "a free-form surface",
    b"call": "a reference to another file",
    b"fo": "a face in an outdated syntax",
}
# Names, looks, parameters of refused shapes, lines and points; some files hold their materials.
IGNORED = frozenset(
    (
        b"vn vt vp l p o g s mg usemtl mtllib usemap maplib lod bevel c_interp d_interp "
        b"shadow_obj trace_obj ctech stech cstype deg bmat step parm trim hole scrv sp con end "
        b"curv2 csh newmtl illum Ka Kd Ks Ke Kt Ns Ni Tr Tf d map_Ka map_Kd map_Ks map_Ns map_d "
        b"map_Bump bump"
    ).split()
)


def parse_obj(data: bytes) -> Content:
    """Read an OBJ file, or raise `RejectedError`, as for free-form curves and surfaces."""
    text = plain_text(data)
    reader = _Reader()
    kept = b""
    for number, line in enumerate([*text.split(b"\n"), b""], 1):  # the last ends what is continued
        if line.endswith(b"\\"):
            kept += line[:-1] + b" "
            continue
        reader.read(number, (kept + line).partition(b"#")[0].split())
        kept = b""
    if reader.unknown and reader.vertices:  # other text has no faces
        raise RejectedError(f"{reader.unknown} is not OBJ")
    vertices = np.array(reader.vertices, np.float64).reshape(-1, 3)
    faces = triangles_of(
        vertices, np.array(reader.corners, np.int64), np.array(reader.lengths, int)
    )
    return Content(vertices, faces, stated_in_comments(data))


class _Reader:
    """Vertices, polygons and the first unknown word of the lines that were read so far."""

    def __init__(self) -> None:
        self.vertices: list[tuple[float, float, float]] = []
        self.corners: list[int] = []
        self.lengths: list[int] = []
        self.unknown = ""
        self._triangles = 0

    def read(self, number: int, words: list[bytes]) -> None:
        """Take a line, as words without a comment."""
        if not words:
            return
        key = words[0]
        if key == b"v":
            self._read_vertex(f"line {number}", words[1:])
        elif key == b"f":
            self._read_face(f"line {number}", words[1:])
        elif key in REFUSED:
            raise RejectedError(
                f"line {number}: `{key.decode()}`, {REFUSED[key]}, is not supported; export "
                "triangles"
            )
        elif key not in IGNORED:
            self.unknown = self.unknown or f"line {number}: {key[:20].decode('latin-1')!r}"

    def _read_vertex(self, where: str, words: list[bytes]) -> None:
        try:
            check_digits(words)
            values = [float(word) for word in words[:4]]
        except ValueError:
            no_number(words[:4], where, float)
        if len(values) < 3:
            raise RejectedError(f"{where}: a vertex has {len(values)} coordinates")
        if len(words) == 4 and values[3] != 1:  # with more, they are colors
            raise RejectedError(f"{where}: a vertex has the weight {values[3]:g}; allowed: 1")
        check_at_most(len(self.vertices) + 1, MAX_VERTICES, "vertices")
        self.vertices.append((values[0], values[1], values[2]))

    def _read_face(self, where: str, words: list[bytes]) -> None:
        indices = [word.partition(b"/")[0] for word in words]
        try:
            check_digits(indices)
            corners = [int(index) for index in indices]
        except ValueError:
            no_number(indices, where, int)
        self._triangles += max(len(corners) - 2, 0)
        check_at_most(self._triangles, MAX_FACES, "faces")
        count = len(self.vertices)  # negative indices count back from here
        self.corners += [k - 1 if k > 0 else count + k if k else -1 for k in corners]
        self.lengths.append(len(corners))


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

"""Wavefront OBJ files of any program: one mesh of all objects, groups and materials."""

import numpy as np

from egad._util.input_limits import MAX_FACES, MAX_VERTICES, check_at_most
from egad.errors import RejectedError
from egad.io.content import Content
from egad.io.polygons import triangles_of
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

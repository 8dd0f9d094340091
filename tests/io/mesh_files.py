"""Mesh files of every kind that people bring, made here, with what is right for each.

All lengths are millimetres unless a case says otherwise. The box is 60 x 40 x 30 mm, 72,000 mm3.
"""

import io
import json
import re
import struct
import zipfile
from typing import NamedTuple

import numpy as np
import trimesh

BOX = trimesh.creation.box((60.0, 40.0, 30.0))
BOX_SIZE, BOX_VOLUME = (60, 40, 30), 72_000.0
QUADS = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


class Case(NamedTuple):
    """A file and what reading it must give.

    Attributes:
        data: Its content.
        size: Sides of the box around the mesh, millimetres; empty if it must be refused.
        volume: Of the closed mesh, mm3; None if it need not be closed.
        refusal: Pattern of the reason, if it must be refused.
        units: Unit to ask for.
    """

    data: bytes
    size: tuple[float, ...] = BOX_SIZE
    volume: float | None = BOX_VOLUME
    refusal: str = ""
    units: str | None = "mm"


def refused(data, reason, units="mm"):
    return Case(data if isinstance(data, bytes) else data.encode(), (), None, reason, units)


def box_of(data, units="mm"):
    return Case(data if isinstance(data, bytes) else data.encode("latin-1"), units=units)


MIXED = [*QUADS[:3], *[(a, b, c) for q in QUADS[3:] for a, b, c in (q[:3], (q[0], *q[2:]))]]
U_SHAPE = [(0, 0), (60, 0), (60, 50), (40, 50), (40, 10), (20, 10), (20, 50), (0, 50)]
U_FACES = [  # of a prism over it: two ends and eight walls
    *[tuple(range(8))[::-1], tuple(range(8, 16))],
    *[(k, (k + 1) % 8, 8 + (k + 1) % 8, 8 + k) for k in range(8)],
]


def numbers(rows):
    return "".join(" ".join(f"{value:.9g}" for value in row) + "\n" for row in rows)


def obj(vertices, faces, head="", tail=""):
    points = "".join("v " + line + "\n" for line in numbers(vertices).splitlines())
    polygons = "".join("f " + " ".join(str(k + 1) for k in face) + "\n" for face in faces)
    return head + points + polygons + tail


def relative(vertices, faces):
    """The same with indices that count back from the end, or forward, by turns."""
    count = len(vertices)
    text = obj(vertices, [], "")
    for row, face in enumerate(faces):
        text += "f " + " ".join(
            str(k - count if (row + j) % 2 else k + 1) for j, k in enumerate(face)
        )
        text += "\n"
    return text


V, F = BOX.vertices, BOX.faces
PLAIN_OBJ = obj(V, F)
TEXTURED = (
    "mtllib box.mtl\no box\n"
    + obj(V, [])
    + "vt 0 0\nvt 1 0 0.5\nvn 0 0 1\ng side\nusemtl red\ns 1\n"
)


def slashes(form, faces=F):
    return TEXTURED + "".join(
        "f " + " ".join(form.format(k + 1, k - 8) for k in face) + "\n" for face in faces
    )


OBJ = {
    "relative.obj": box_of(relative(V, QUADS)),
    "quads.obj": box_of(obj(V, QUADS)),
    "v_vn.obj": box_of(slashes("{0}//1")),
    "v_vt_vn.obj": box_of(slashes("{0}/1/1", QUADS)),
    "relative_v_vt_vn.obj": box_of(slashes("{1}/-1/-1")),
    "colours.obj": box_of(obj(np.hstack([V, np.full((8, 3), 0.5)]), F)),
    "homogeneous.obj": box_of(obj(np.hstack([V, np.ones((8, 1))]), F)),
    "weights.obj": refused(obj(np.hstack([2 * V, np.full((8, 1), 2.0)]), F), "weight"),
    "continued.obj": box_of(PLAIN_OBJ.replace("f 2 4 1", "f 2 4 \\\n 1")),
    "bom.obj": box_of(b"\xef\xbb\xbf" + PLAIN_OBJ.encode()),
    "cr.obj": box_of(PLAIN_OBJ.replace("\n", "\r")),
    "crlf_comments.obj": box_of(obj(V, QUADS, "# K\xf6rper\n", "\n# end\n").replace("\n", "\r\n")),
    "lines_and_points.obj": box_of(PLAIN_OBJ + "l 1 2\np 1\n"),
    "faces_first.obj": box_of(obj(V, F).replace(obj(V, []), "") + obj(V, [])),
    "curves.obj": refused(obj(V, F) + "cstype bezier\ndeg 2\ncurv 0 1 1 2 3\nend\n", "curv"),
    "surfaces.obj": refused(obj(V, []) + "cstype bspline\nsurf 0 1 0 1 1 2 3 4\nend\n", "surf"),
    "decimal_commas.obj": refused(PLAIN_OBJ.replace(".5", ",5").replace("30 ", "30,0 "), "comma"),
    "utf16.obj": refused(PLAIN_OBJ.encode("utf-16"), "UTF-16"),
    "underscores.obj": refused(PLAIN_OBJ.replace("-30", "-3_0"), r"line 1: '-3_0' is not a number"),
    "face_underscores.obj": refused(PLAIN_OBJ.replace("f 2 4 1", "f 2 4 1_0"), "not a number"),
    "no_corner.obj": refused(PLAIN_OBJ.replace("f 2 4 1", "f 2 4 9"), "do not exist"),
    "html.obj": refused("<!DOCTYPE html>\n<html>Not found</html>", "no faces"),
    "upper_case.obj": refused(PLAIN_OBJ.replace("f ", "F "), "line 9: 'F' is not OBJ"),
    "too_far_back.obj": refused(obj(V, F).replace("f 2 4 1", "f 2 4 -9"), "do not exist"),
    "nan.obj": refused(PLAIN_OBJ.replace("v -30 ", "v nan ", 1), "not finite"),
    "says_dm.obj": refused("# unit: dm\n" + PLAIN_OBJ, "states the unit dm, but mm"),
    "says_nothing.obj": refused(PLAIN_OBJ, "units", None),
}


def facets(mesh=BOX, count=None, header=b"", tail=b""):
    """A binary STL file."""
    body = np.zeros(len(mesh.faces), [("n", "<f4", 3), ("c", "<f4", (3, 3)), ("a", "<u2")])
    body["c"], body["n"] = mesh.triangles, mesh.face_normals
    count = len(body) if count is None else count
    return header.ljust(80, b"\0") + struct.pack("<I", count) + body.tobytes() + tail


def ascii_stl(name="box", mesh=BOX, end=True):
    text = f"solid {name}\n"
    for corners in mesh.triangles:
        text += "  facet normal 0 0 0\n    outer loop\n"
        text += "".join(f"      vertex {x:.6e} {y:.6e} {z:.6e}\n" for x, y, z in corners)
        text += "    endloop\n  endfacet\n"
    return text + (f"endsolid {name}\n" if end else "")


OBJ["binary.obj"] = refused(facets(), "binary, not text")
UPPER = BOX.copy().apply_translation([0, 0, 40])
STL = {
    "solid_header.stl": box_of(facets(header=b"solid box facet")),
    "count_small.stl": refused(facets(count=7), "says 7 .* holds 12"),
    "cut.stl": refused(facets()[:-20], "truncated"),
    "trailing_bytes.stl": box_of(facets(tail=bytes(34))),
    "header_only.stl": refused(facets()[:84].replace(b"\x0c", b"\0"), "no faces"),
    "solid_header_count_large.stl": refused(facets(count=99, header=b"solid box"), "truncated"),
    "says_mm.stl": box_of(facets(header=b"egad, unit: millimetre"), None),
    "says_cm.stl": Case(facets(header=b"UNITS=cm"), (600, 400, 300), BOX_VOLUME * 1000, "", None),
    "silent.stl": refused(facets(), "units", None),
    "ascii_cr.stl": box_of(ascii_stl().replace("\n", "\r")),
    "ascii_blank_start.stl": box_of("\n\n" + ascii_stl()),
    "ascii_no_name.stl": box_of(ascii_stl("")),
    "ascii_named_vertex.stl": box_of(ascii_stl("my facet vertex 1 2")),
    "ascii_two_no_endsolid.stl": Case(
        (ascii_stl("a", end=False) + ascii_stl("b", UPPER)).encode(), (60, 40, 70), 2 * BOX_VOLUME
    ),
    "ascii_cut_number.stl": refused(ascii_stl()[: ascii_stl().rindex("vertex") + 12], "truncated"),
    "ascii_commas.stl": refused(ascii_stl().replace(".", ","), "comma"),
    "quads.stl": refused(
        ascii_stl().replace("    endloop", "      vertex 0 0 0\n    endloop", 1), "3 corners"
    ),
    "empty.stl": refused(b"", "empty"),
    "count_zero_cut.stl": refused(facets(count=0)[:-20], "truncated within face 12"),
    "starts_with_facet.stl": refused(ascii_stl().partition("\n")[2], "starts with `solid`"),
    "utf16_without_mark.stl": refused(ascii_stl().encode("utf-16-le"), "UTF-16"),
}


def off(head, rows, faces, between="\n"):
    counts = "" if head.count(" ") else f"\n{len(rows)} {len(faces)} 0"
    polygons = "".join(f"{len(face)} " + " ".join(map(str, face)) + "\n" for face in faces)
    return head + counts + between + numbers(rows) + polygons


def coloured(faces, colour):
    return "".join(f"{len(f)} " + " ".join(map(str, f)) + f" {colour}\n" for f in faces)


UP = np.tile([0.0, 0, 1], (8, 1))
COLOUR, TEXTURE = np.tile([255, 0, 0, 255], (8, 1)), np.zeros((8, 2))
OFF = {
    "plain.off": box_of(off("OFF", V, F)),
    "coff_rgb.off": box_of(off("COFF", np.hstack([V, COLOUR[:, :3] / 255]), QUADS)),
    "cnoff.off": box_of(off("CNOFF", np.hstack([V, UP, COLOUR]), F)),
    "stoff.off": box_of(off("STOFF", np.hstack([V, TEXTURE]), F)),
    "stcnoff.off": box_of(off("STCNOFF", np.hstack([V, UP, COLOUR, TEXTURE]), QUADS)),
    "no_header.off": box_of(off("8 12 0", V, F)),
    "two_counts.off": box_of(off("OFF 8 12", V, F)),
    "between.off": box_of(off("OFF", V, F).replace("\n3 ", "\n# a face\n3 ")),
    "one_line.off": box_of(off("OFF", V, F).replace("\n", " ")),
    "word_a_line.off": box_of(off("OFF", V, MIXED).replace(" ", "\n")),
    "colours_on_one_line.off": refused(
        off("COFF", np.hstack([V, COLOUR]), F).replace("\n", " "), "one vertex or face per line"
    ),
    "face_colours_on_one_line.off": refused(
        (off("OFF 8 12 0", V, []) + coloured(F, "3")).replace("\n", " "), "one vertex or face per"
    ),
    "one_line_cut.off": refused(off("OFF", V, F).replace("\n", " ")[:-4], "truncated"),
    "negative_length.off": refused(off("OFF", V, F).replace("3 1 3 0", "-3 1 3 0"), "-3 corners"),
    "cr.off": box_of(off("OFF", V, F).replace("\n", "\r")),
    "bom_crlf.off": box_of(b"\xef\xbb\xbf" + off("OFF", V, F).replace("\n", "\r\n").encode()),
    "face_rgb.off": box_of(off("OFF 8 6 0", V, []) + coloured(QUADS, "0.9 0.1 0.1")),
    "face_index.off": box_of(off("OFF 8 12 0", V, []) + coloured(F, "3")),
    "face_mixed.off": box_of(
        off("OFF 8 9 0", V, [])
        + coloured(QUADS[:3], "1 0 0")
        + coloured([(a, b, c) for q in QUADS[3:] for a, b, c in (q[:3], (q[0], *q[2:]))], "")
    ),
    "edges.off": box_of(off("OFF", V, [*F, (0, 1), (2,)])),
    "binary.off": refused(b"OFF BINARY\n" + struct.pack(">3i", 8, 12, 0) + bytes(300), "[Bb]inary"),
    "four.off": refused(off("4OFF", np.hstack([V, UP[:, :1]]), F), "4OFF"),
    "n.off": refused("nOFF 3\n8 12 0\n" + numbers(V), "nOFF"),
    "cut.off": refused(off("OFF", V, F)[:-40], "truncated"),
    "index.off": refused(off("OFF", V, F).replace("3 1 3 0", "3 1 3 8", 1), "do not exist"),
    "word.off": refused(off("OFF", V, F).replace("-20", "x", 1), "number"),
    "other.off": refused("OBJ\n" + off("OFF", V, F), "OFF"),
}

PLY_KINDS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}


def ply(kind, elements):
    """A PLY file.

    Args:
        kind: One of `PLY_KINDS`.
        elements: For each its name, properties (type, name) or (count type, type, name), and rows.
    """
    head, body = f"ply\nformat {kind} 1.0\ncomment made for a test\n", b""
    for name, properties, rows in elements:
        head += f"element {name} {len(rows)}\n"
        for each in properties:
            head += f"property {'list ' if len(each) == 3 else ''}{' '.join(each)}\n"
        for row in rows:
            body += ply_row(kind, properties, row)
    return (head + "end_header\n").encode() + body


CODES = {"char": "b", "uchar": "B", "short": "h", "ushort": "H", "int": "i", "uint": "I"}
CODES |= {"float": "f", "double": "d", "uint8": "B", "int32": "i", "float32": "f", "float64": "d"}


def ply_row(kind, properties, row):
    words, packed = [], b""
    for each, value in zip(properties, row, strict=True):
        order = PLY_KINDS[kind] or "<"
        if len(each) == 3:
            words += [len(value), *value]
            packed += struct.pack(order + CODES[each[0]], len(value))
            packed += struct.pack(f"{order}{len(value)}{CODES[each[1]]}", *value)
        else:
            words.append(value)
            packed += struct.pack(order + CODES[each[0]], value)
    return (" ".join(map(str, words)) + "\n").encode() if kind == "ascii" else packed


XYZ = [("float", "x"), ("float", "y"), ("float", "z")]
FACE = [("uchar", "int", "vertex_indices")]
ROWS = V.tolist()
WHOLE = [("char", "x"), ("short", "y"), ("int", "z")]
TRIANGLES = [(tuple(face),) for face in F.tolist()]
STRIPS = [0, 1, 2, 3, 6, 7, 4, 5, 0, 1, -1, 0, 2, 4, 6, -1, 1, 5, 3, 7, -1]


def plys(kind):
    """Files with everything that PLY has, as text or in a byte order."""

    def made(*elements):
        return box_of(ply(kind, elements))

    faces = [(tuple(face),) for face in F.tolist()]
    mixed = [(face,) for face in MIXED]
    return {
        "plain": made(("vertex", XYZ, ROWS), ("face", FACE, faces)),
        "mixed": made(("vertex", XYZ, ROWS), ("face", FACE, mixed)),
        "shuffled": made(
            (
                "vertex",
                [("uchar", "red"), XYZ[2], XYZ[0], ("double", "quality"), XYZ[1]],
                [(9, z, x, 0.25, y) for x, y, z in ROWS],
            ),
            ("face", [("uchar", "flag"), *FACE, ("float", "area")], [(1, *f, 2.5) for f in mixed]),
        ),
        "extra_elements": made(
            ("camera", [("float", "f"), ("uchar", "int", "views")], [(1.0, (1, 2)), (2.0, ())]),
            ("vertex", XYZ, ROWS),
            ("edge", [("int", "vertex1"), ("int", "vertex2")], [(0, 1), (2, 3)]),
            ("face", FACE, mixed),
            ("material", [("uchar", "red")], [(1,)]),
        ),
        "faces_first": made(("face", FACE, mixed), ("vertex", XYZ, ROWS)),
        "strips": made(
            ("vertex", XYZ, ROWS), ("tristrips", [("int", "int", "vertex_indices")], [(STRIPS,)])
        ),
    }


PLY = {f"{name}_{kind}.ply": case for kind in PLY_KINDS for name, case in plys(kind).items()}
ASCII_PLY = PLY["plain_ascii.ply"].data
PLY |= {
    "crlf.ply": box_of(ASCII_PLY.replace(b"\n", b"\r\n")),
    "cr.ply": box_of(ASCII_PLY.replace(b"\n", b"\r")),
    **{
        f"more_faces_{name}_{kind}.ply": refused(
            PLY[f"{name}_{kind}.ply"].data.replace(b"element face " + count, b"element face 6"),
            "holds more",
        )
        for kind in PLY_KINDS
        for name, count in (("plain", b"12"), ("mixed", b"9"))
    },
    **{
        f"whole_{kind}.ply": box_of(
            ply(kind, [("vertex", WHOLE, V.astype(int).tolist()), ("face", FACE, TRIANGLES)])
        )
        for kind in PLY_KINDS
    },
    **{
        f"{name}.ply": refused(
            ply(
                "ascii", [("vertex", WHOLE, V.astype(int).tolist()), ("face", FACE, TRIANGLES)]
            ).replace(old, new, 1),
            reason,
        )
        for name, old, new, reason in (
            ("negative_uchar", b"char x", b"uchar x", "-30 .* uint8 of x"),
            ("fraction", b"-20 ", b"-20.5 ", "-20.5 .* int16 of y"),
            ("too_large", b"-30 ", b"-129 ", "-129 .* int8 of x"),
            ("not_finite", b"-30 ", b"nan ", "nan .* int8 of x"),
        )
    },
    "trailing_lines.ply": box_of(PLY["plain_binary_big_endian.ply"].data + b"\r\nmade here\n\0"),
    "header_crlf.ply": box_of(
        PLY["mixed_binary_little_endian.ply"].data.replace(b"\n", b"\r\n", 11)
    ),
    "cut_ascii.ply": refused(ASCII_PLY[:-20], "truncated"),
    "cut_binary.ply": refused(PLY["mixed_binary_little_endian.ply"].data[:-9], "truncated"),
    "commas.ply": refused(ASCII_PLY.replace(b"0.0 ", b"0,0 "), "comma"),
    "negative.ply": refused(ASCII_PLY.replace(b"3 1 3 0", b"-3 1 3 0", 1), "negative"),
    "negative_binary.ply": refused(
        ply(
            "binary_big_endian",
            [
                ("vertex", XYZ, ROWS),
                (
                    "face",
                    [("uchar", "int", "vertex_indices"), ("char", "int", "more")],
                    [QUADS[:2]],
                ),
            ],
        )[:-17]
        + b"\xff",
        "negative",
    ),
    "cloud.ply": refused(ply("ascii", [("vertex", XYZ, ROWS)]), "no faces"),
    "list_of_vertices.ply": refused(
        ply("ascii", [("vertex", XYZ, ROWS), ("face", [("uchar", "int", "vertices")], TRIANGLES)]),
        "faces do not have a list vertex_indices",
    ),
    **{
        f"{name}.ply": refused(
            ply("binary_big_endian", [("vertex", XYZ, ROWS), (name, FACE, TRIANGLES)]),
            f"its element {name} is not supported",
        )
        for name in ("trifans", "range_grid")
    },
    "no_fans.ply": box_of(
        ply("ascii", [("vertex", XYZ, ROWS), ("face", FACE, TRIANGLES), ("trifans", FACE, [])])
    ),
    "no_z.ply": refused(
        ply("ascii", [("vertex", XYZ[:2], [r[:2] for r in ROWS]), ("face", FACE, [((0, 1, 2),)])]),
        "x, y and z",
    ),
    "index.ply": refused(ASCII_PLY.replace(b"3 1 3 0", b"3 1 3 8"), "do not exist"),
    "version.ply": refused(ASCII_PLY.replace(b"ascii 1.0", b"ascii 2.0"), "2.0"),
    "type.ply": refused(ASCII_PLY.replace(b"float x", b"half x"), "half"),
    "says_metres.ply": refused(ASCII_PLY.replace(b"made for a test", b"unit: metre"), r"\bm\b"),
}

for lift in (0.0, 0.5):  # of one corner of each end: polygons that are not flat
    points = np.array([(*place, z) for z in (0.0, 15.0) for place in U_SHAPE])
    points[[0, 8], 2] += lift
    name, expected = f"u{lift:g}", ((60, 50, 15 + lift), 2200 * 15.0)
    OBJ[f"{name}.obj"] = Case(obj(points, U_FACES).encode(), *expected)
    OFF[f"{name}.off"] = Case(off("OFF", points, U_FACES).encode(), *expected)
    for kind in PLY_KINDS:
        elements = ("vertex", XYZ, points.tolist()), ("face", FACE, [(each,) for each in U_FACES])
        PLY[f"{name}_{kind}.ply"] = Case(ply(kind, elements), *expected)


METRES_BOX = np.asarray(V) / 1000  # glTF is in metres, with y up
UP_SIZE = (60, 30, 40)  # the z of the mesh is the y of the file


def glb(document, binary=b""):
    """A GLB file of a document and its binary chunk."""
    binary += bytes(-len(binary) % 4)
    if binary:
        document = {"buffers": [{"byteLength": len(binary)}], **document}
    text = json.dumps({"asset": {"version": "2.0"}, **document}).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
    if binary:
        chunks += struct.pack("<II", len(binary), 0x004E4942) + binary
    return struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks


DRACO, MESHOPT = "KHR_draco_mesh_compression", "EXT_meshopt_compression"
COMPONENTS = {"int8": 5120, "uint8": 5121, "int16": 5122, "uint16": 5123, "uint32": 5125}
COMPONENTS |= {"float32": 5126}
SHAPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}


def gltf(points, indices=None, nodes=({"mesh": 0},), mode=None, more=None, accessor=None, **extra):
    """A GLB file with one primitive.

    Args:
        points: (n, 3) array of any type.
        indices: Array, or None.
        nodes: Of the document; the first is the root.
        mode: Of the primitive.
        more: Further arrays, which become accessors 2, 3, ...
        accessor: Further entries of the accessor of the positions.
        extra: Further entries of the document.
    """
    arrays = [points, indices if indices is not None else np.zeros(1, "uint8"), *(more or [])]
    views, accessors, binary = [], [], b""
    for array in map(np.asarray, arrays):
        wide = array.reshape(len(array), -1)
        stride = -(-wide.shape[1] * array.itemsize // 4) * 4
        padded = np.zeros((len(array), stride), "uint8")
        padded[:, : wide.shape[1] * array.itemsize] = wide.view("uint8").reshape(len(array), -1)
        tight = array.ndim == 1
        data = array.tobytes() if tight else padded.tobytes()
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data)})
        if not tight:
            views[-1]["byteStride"] = stride
        binary += data + bytes(-len(data) % 4)
        accessors.append(
            {
                "bufferView": len(views) - 1,
                "componentType": COMPONENTS[array.dtype.name],
                "count": len(array),
                "type": SHAPES[wide.shape[1]],
            }
        )
    accessors[0] |= accessor or {}
    primitive = {"attributes": {"POSITION": 0}}
    if indices is not None:
        primitive["indices"] = 1
    if mode is not None:
        primitive["mode"] = mode
    document = {
        "bufferViews": views,
        "accessors": accessors,
        "meshes": [{"primitives": [primitive]}],
        "nodes": list(nodes),
        "scenes": [{"nodes": [0]}],
        "scene": 0,
    }
    return glb(document | extra, binary)


POINTS, CORNERS = METRES_BOX.astype("float32"), F.ravel().astype("uint16")


def upright(data, volume=BOX_VOLUME, size=UP_SIZE):
    return Case(data, size, volume, "", None)


def box_glb(*nodes, **more):
    """The box with some nodes, usually one that shows it, and more entries of `gltf`."""
    return gltf(POINTS, CORNERS, nodes or ({"mesh": 0},), **more)


def no_glb(reason, *nodes, **more):
    """A box that must be refused, or the data of another file."""
    data = nodes[0] if nodes and isinstance(nodes[0], bytes) else box_glb(*nodes, **more)
    return refused(data, reason, None)


def quantised(kind, normalized):
    """A box with whole numbers as positions, 0.03 m at the largest."""
    top = np.iinfo(kind).max
    node = {"mesh": 0, "scale": [0.03 if normalized else 0.03 / top] * 3}
    points = np.round(METRES_BOX / 0.03 * top)
    if kind.startswith("u"):
        points = np.round((METRES_BOX / 0.03 + 1) / 2 * top)
        node["scale"] = [2 * each for each in node["scale"]]
    accessor = {"normalized": True} if normalized else None
    extension = {"extensionsRequired": ["KHR_mesh_quantization"]}
    return gltf(points.astype(kind), CORNERS, [node], accessor=accessor, **extension)


def sparse(with_base):
    """A box, of which two corners are where they belong only by the sparse part."""
    wrong = POINTS.copy()
    wrong[[1, 6]] = 0
    if not with_base:
        wrong[:] = 0
    which = np.array([1, 6] if with_base else range(8), "uint16")
    data = gltf(wrong, CORNERS, more=[which, POINTS[which]])
    size = int.from_bytes(data[12:16], "little")
    document, binary = json.loads(data[20 : 20 + size]), data[28 + size :]
    document["accessors"][0]["sparse"] = {
        "count": len(which),
        "indices": {"bufferView": 2, "componentType": 5123},
        "values": {"bufferView": 3},
    }
    del document["bufferViews"][3]["byteStride"]
    if not with_base:
        del document["accessors"][0]["bufferView"]
    return glb(document, binary)


def instanced(*names, **arrays):
    node = {
        "mesh": 0,
        "extensions": {
            "EXT_mesh_gpu_instancing": {"attributes": {name: 2 + k for k, name in enumerate(names)}}
        },
    }
    return gltf(
        POINTS,
        CORNERS,
        [node],
        more=[np.asarray(arrays[name], "float32") for name in names],
        extensionsUsed=["EXT_mesh_gpu_instancing"],
    )


def changed(data, change):
    """A GLB file with another document."""
    size = int.from_bytes(data[12:16], "little")
    document = json.loads(data[20 : 20 + size])
    change(document)
    return glb(document, data[28 + size :])


def morphed(usual):
    """A box with two other shapes that it may turn into."""

    def change(document):
        (mesh,) = document["meshes"]
        mesh["primitives"][0]["targets"] = [{"POSITION": 2}, {"POSITION": 2}]
        mesh["weights"] = usual

    return changed(gltf(POINTS, CORNERS, [{"mesh": 0}], more=[POINTS * 0.1]), change)


def many_primitives():
    """A box of a strip around it, a fan, and two triangles, which share their vertices."""
    around = np.array([0, 1, 2, 3, 6, 7, 4, 5, 0, 1], "uint16")
    fan, rest = np.array([0, 2, 6, 4], "uint16"), np.array([1, 5, 7, 1, 7, 3], "uint16")

    def change(document):
        document["meshes"][0]["primitives"] = [
            {"attributes": {"POSITION": 0}, "indices": indices, "mode": mode}
            for indices, mode in ((1, 5), (2, 6), (3, 4))
        ]

    return changed(gltf(POINTS, around, more=[fan, rest]), change)


def packed_views():
    """A box whose positions are compressed, which the document does not call required."""

    def change(document):
        document["bufferViews"][0]["extensions"] = {MESHOPT: {"buffer": 0, "mode": "ATTRIBUTES"}}

    return changed(gltf(POINTS, CORNERS, extensionsUsed=[MESHOPT]), change)


HALF = float(np.sqrt(0.5))
MATRIX = [0, 2.0, 0, 0, -1.0, 0, 0, 0, 0, 0, 1.0, 0, 0.5, 0, 0, 1]  # x to 2 y, y to -x, by columns
STRIP = [0, 1, 2, 3, 6, 7, 4, 5, 0, 1]
FAN = [0, 1, 3, 2, 6, 4, 5, 1]  # around corner 0
VISIBILITY = "KHR_node_visibility"
HIDDEN = {"extensions": {VISIBILITY: {"visible": False}}}
ONE_MORE = {"mesh": 0, "translation": [0.2, 0, 0]}
GLB = {
    "plain.glb": upright(box_glb()),
    "uint32.glb": upright(gltf(POINTS, CORNERS.astype("uint32"))),
    "no_indices.glb": upright(gltf(POINTS[F].reshape(-1, 3))),
    "sparse.glb": upright(sparse(True)),
    "sparse_alone.glb": upright(sparse(False)),
    "matrix.glb": upright(box_glb({"mesh": 0, "matrix": MATRIX}), 2 * 72_000, (40, 30, 120)),
    "mirrored.glb": upright(box_glb({"mesh": 0, "scale": [-1, 1, 1]})),
    "default_scene.glb": upright(
        box_glb({"mesh": 0}, ONE_MORE, scenes=[{"nodes": [1]}, {"nodes": [0]}], scene=1)
    ),
    "mm_asked.glb": Case(gltf(POINTS * 1000, CORNERS), UP_SIZE, BOX_VOLUME, "", "mm"),
    "instanced.glb": upright(
        instanced(
            "TRANSLATION",
            "ROTATION",
            "SCALE",
            TRANSLATION=[[0, 0, 0], [0.2, 0, 0]],
            ROTATION=[[0, 0, 0, 1], [-HALF, 0, 0, HALF]],
            SCALE=[[1, 1, 1], [2, 2, 2]],
        ),
        9 * 72_000,
        (290, 80, 60),
    ),
    "strip.glb": Case(gltf(POINTS, np.array(STRIP, "uint16"), mode=5), UP_SIZE, None, "", None),
    "fan.glb": Case(gltf(POINTS, np.array(FAN, "uint16"), mode=6), UP_SIZE, None, "", None),
    "hidden.glb": upright(
        box_glb(
            *({"children": [1, 2]}, {"mesh": 0}, {**ONE_MORE, **HIDDEN, "children": [3]}, ONE_MORE),
            extensionsUsed=[VISIBILITY],
            extensionsRequired=[VISIBILITY],
        )
    ),
    "all_hidden.glb": no_glb("no faces", {"mesh": 0, **HIDDEN}),
    "unlit_required.glb": upright(
        box_glb(extensionsRequired=["KHR_materials_unlit", "KHR_texture_transform"])
    ),
    "meshopt.glb": no_glb(MESHOPT, extensionsRequired=[MESHOPT]),
    "meshopt_fallback.glb": no_glb(MESHOPT, packed_views()),
    "lines.glb": no_glb("no faces", mode=1),
    "skinned.glb": no_glb("skin", {"mesh": 0, "skin": 0}, skins=[{"joints": [0]}]),
    "morphed.glb": no_glb("morph", morphed([0, 0.5])),
    "many_primitives.glb": upright(many_primitives()),
    "no_scene.glb": no_glb("no faces", gltf(POINTS, CORNERS, nodes=[], scenes=[{"nodes": []}])),
    "other_file.glb": no_glb("other file", buffers=[{"byteLength": 136, "uri": "box.bin"}]),
    "cut.glb": no_glb("truncated", box_glb()[:-30]),
    "sparse_outside.glb": no_glb(
        "refers to something that is missing",
        changed(sparse(True), lambda document: document["accessors"][0].update(count=5)),
    ),
    "no_positions.glb": no_glb(
        "has no POSITION",
        changed(box_glb(), lambda doc: doc["meshes"][0]["primitives"][0]["attributes"].clear()),
    ),
    "component_type.glb": no_glb("component type 5199", accessor={"componentType": 5199}),
    "instanced_nowhere.glb": no_glb("does not say where", instanced()),
    "not_json.glb": no_glb("JSON", box_glb().replace(b'"asset"', b"'asset'")),
    "version_1.glb": no_glb("version 1", struct.pack("<III", 0x46546C67, 1, 20) + bytes(8)),
}
GLB |= {
    f"quantised_{kind}{'_normalized' * normalized}.glb": upright(quantised(kind, normalized))
    for kind in ("int8", "int16", "uint8", "uint16")
    for normalized in (False, True)
}

CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
PRODUCTION = "http://schemas.microsoft.com/3dmanufacturing/production/2015/06"
TYPES = (
    '<?xml version="1.0" encoding="UTF-8"?>'
    '<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">'
    '<Default Extension="rels" '
    'ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
    '<Default Extension="model" '
    'ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>'
)
MODEL_KIND = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"


def relations(*targets):
    inside = "".join(
        f'<Relationship Target="{target}" Id="rel{k}" Type="{MODEL_KIND}"/>'
        for k, target in enumerate(targets)
    )
    return (
        '<?xml version="1.0" encoding="UTF-8"?><Relationships '
        f'xmlns="http://schemas.openxmlformats.org/package/2006/relationships">{inside}'
        "</Relationships>"
    )


def package(model, where="3D/3dmodel.model", others=None):
    """A 3MF file of a model part and others by their paths."""
    parts = {"[Content_Types].xml": TYPES, "_rels/.rels": relations(f"/{where}"), where: model}
    if others:
        folder, _, name = where.rpartition("/")
        parts[f"{folder}/_rels/{name}.rels"] = relations(*(f"/{other}" for other in others))
        parts |= others
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, text in parts.items():
            archive.writestr(path, text)
    return data.getvalue()


def solid_xml(number, vertices=V, faces=F, kind=' type="model"', more=""):
    points = "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in np.asarray(vertices))
    triangles = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in faces)
    return (
        f'<object id="{number}"{kind}{more}><mesh><vertices>{points}</vertices>'
        f"<triangles>{triangles}</triangles></mesh></object>"
    )


def assembly(number, *components):
    inside = "".join(f"<component {each}/>" for each in components)
    return f'<object id="{number}" type="model"><components>{inside}</components></object>'


def model(objects, items=('objectid="1"',), unit=' unit="millimeter"', head=""):
    build = "".join(f"<item {item}/>" for item in items)
    return (
        f'<?xml version="1.0" encoding="UTF-8"?><model{unit} xml:lang="en-US" xmlns="{CORE}" '
        f'xmlns:p="{PRODUCTION}"{head}><resources>{objects}</resources>'
        f"<build>{build}</build></model>"
    )


def asked(data, units, size=BOX_SIZE, volume=BOX_VOLUME):
    return Case(data, size, volume, "", units)


def built(objects, items=('objectid="1"',), size=BOX_SIZE, volume=BOX_VOLUME, **more):
    """A file of objects of which some items are built."""
    return asked(package(model(objects, items, **more)), None, size, volume)


def not_built(reason, objects, items=('objectid="1"',), **more):
    return refused(package(model(objects, items, **more)), reason, None)


def unit(name, length):
    """A box in some unit."""
    text = f' unit="{name}"' if name else ""
    return package(model(solid_xml(1, V / length), unit=text))


SHIFT = "1 0 0 0 1 0 0 0 1 0 0 24.9"
SMALL = solid_xml(2, V / 2)
UPRIGHT_TURN = "0 1 0 -1 0 0 0 0 1 5 6 7"  # x to y, y to -x
PART = 'p:path="/3D/part.model"'


def encrypted(data):
    """The archive with the flag of encryption at all of its entries."""
    marked = bytearray(data)
    for signature, place in ((b"PK\x03\x04", 6), (b"PK\x01\x02", 8)):
        for found in re.finditer(re.escape(signature), data):
            marked[found.start() + place] |= 1
    return bytes(marked)


MILLIMETER, INCH = ' unit="millimeter"', ' unit="inch"'


def part_of_unit(root, part):
    """A box in a part of its own, where both models may state a unit."""
    return package(
        model("", [f'objectid="5" {PART}'], root, ' requiredextensions="p"'),
        others={"3D/part.model": model(solid_xml(5), [], part)},
    )


BOTH = ['objectid="1"', 'objectid="2"']
THREEMF = {
    "asked_mm.3mf": asked(unit("millimeter", 1), "mm"),
    "inch_asked_mm.3mf": refused(unit("inch", 25.4), "inch.*mm"),
    "foot.3mf": asked(unit("foot", 304.8), None),
    "silent.3mf": asked(unit("", 1), None),
    "cubit.3mf": refused(unit("cubit", 1), "cubit", None),
    "components.3mf": built(
        solid_xml(1) + SMALL + assembly(3, 'objectid="1"', f'objectid="2" transform="{SHIFT}"'),
        ['objectid="3"'],
        (60, 40, 47.4),
        81_000,
    ),
    "transforms.3mf": built(
        solid_xml(1) + assembly(2, f'objectid="1" transform="{UPRIGHT_TURN}"'),
        ['objectid="2" transform="2 0 0 0 1 0 0 0 1 0 0 0"'],
        (80, 60, 30),
        144_000,
    ),
    "not_built.3mf": built(solid_xml(1) + solid_xml(7, V * 9)),
    "support.3mf": built(solid_xml(1) + solid_xml(2, V * 3, kind=' type="support"'), BOTH),
    "only_support.3mf": not_built("support", solid_xml(1, kind=' type="support"')),
    "surface.3mf": built(solid_xml(1) + solid_xml(2, V * 3, F[:4], kind=' type="surface"'), BOTH),
    "other_place.3mf": asked(package(model(solid_xml(1)), "parts/body.model"), None),
    "production.3mf": asked(
        package(
            model(
                assembly(1, f'objectid="5" {PART}', f'objectid="5" {PART} transform="{SHIFT}"'),
                head=' requiredextensions="p"',
            ),
            others={"3D/part.model": model(solid_xml(5), [])},
        ),
        None,
        (60, 40, 54.9),
        144_000,
    ),
    **{
        f"unit_{'stated' if root else 'silent'}_part_{'stated' if part else 'silent'}.3mf": asked(
            part_of_unit(root, part), None
        )
        for root in ("", MILLIMETER)
        for part in ("", MILLIMETER)
    },
    "unit_of_part_asked_inch.3mf": refused(part_of_unit("", MILLIMETER), "mm, but inch", "inch"),
    "unit_inch_part_silent.3mf": refused(part_of_unit(INCH, ""), "different units", None),
    "not_printed.3mf": built(
        solid_xml(1) + solid_xml(2, V * 3), ['objectid="1"', 'objectid="2" printable="0"']
    ),
    "lattice.3mf": refused(
        package(
            model(solid_xml(1), head=' xmlns:b="urn:beams"').replace(
                "</triangles>", "</triangles><b:beamlattice/>"
            )
        ),
        "beamlattice",
        None,
    ),
    "unknown_required.3mf": not_built(
        "urn:acme/fold", solid_xml(1), head=' xmlns:z="urn:acme/fold" requiredextensions="z"'
    ),
    "missing_object.3mf": not_built("object 9", solid_xml(1), ['objectid="9"']),
    "nothing_built.3mf": not_built("build|no faces", solid_xml(1), []),
    "not_a_zip.3mf": refused(b"PK\x03\x04 but no more", "zip", None),
    "cut_xml.3mf": refused(package(model(solid_xml(1))[:-200]), "it is damaged: .*line 1", None),
    "encrypted.3mf": refused(encrypted(package(model(solid_xml(1)))), "encrypted", None),
    "utf16.3mf": asked(
        package(model(solid_xml(1)).replace("UTF-8", "UTF-16").encode("utf-16")), None
    ),
    "no_model.3mf": refused(
        package("").replace(b"3dmodel.model", b"2dmodel.model"), "missing", None
    ),
}
CASES = {**OBJ, **STL, **OFF, **PLY, **GLB, **THREEMF}

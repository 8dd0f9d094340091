"""Mesh files that are damaged, promise more than they hold, or unfold to very much."""

import io
import json
import struct
import zipfile

import numpy as np
import trimesh
from hypothesis import strategies as st

from egad.io import ENDINGS
from egad.io.threemf import CORE

BALL = trimesh.creation.icosphere(subdivisions=1)
MEGABYTE = 1 << 20
BILLION = 1_000_000_000


def ply(kind, head):
    return f"ply\nformat {kind} 1.0\n{head}end_header\n".encode() + bytes(64)


def vertices(count):
    return f"element vertex {count}\nproperty float x\nproperty float y\nproperty float z\n"


def faces(count):
    return f"element face {count}\nproperty list uchar int vertex_indices\n"


def glb(tree, content=bytes(64)):
    text = json.dumps({"asset": {"version": "2.0"}, **tree}).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
    chunks += struct.pack("<II", len(content), 0x004E4942) + content
    return struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks


def accessor(count, **more):
    return {"componentType": 5126, "count": count, "type": "VEC3"} | more


def scene(nodes, count=3):
    """Nodes with one triangle."""
    return {
        "buffers": [{"byteLength": 64}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "accessors": [accessor(count, bufferView=0)],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "nodes": nodes,
        "scenes": [{"nodes": [0]}],
    }


def packed(**files):
    """A 3MF file, its parts by their names."""
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in files.items():
            archive.writestr(name.replace("__", "/").replace("_", "."), text)
    return data.getvalue()


def model(objects, head="", item="1"):
    build = f'<build><item objectid="{item}"/></build>'
    return f'{head}<model xmlns="{CORE}"><resources>{objects}</resources>{build}</model>'


def plate(*arguments, **more):
    return packed(**{"3D__3dmodel_model": model(*arguments, **more)})


def assembled(name, part, times=1):
    """A 3MF file of an object that refers to object 2 of another part, so many times."""
    reference = f'<component objectid="2" path="/3D/{name.rpartition("__")[2].replace("_", ".")}"/>'
    whole = model(f'<object id="1"><components>{times * reference}</components></object>')
    return packed(**{"3D__3dmodel_model": whole, name: part})


FACE = '<triangle v1="0" v2="1" v3="2"/>'
TRIANGLE = (
    '<mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="1" y="0" z="0"/>'
    '<vertex x="0" y="1" z="0"/></vertices><triangles><triangle v1="0" v2="1" v3="2"/>'
    "</triangles></mesh>"
)
MANY_FACES = TRIANGLE.replace(FACE, FACE * 20_000)


def doubled(depth):
    """Objects, each made of two of the next: 2^depth triangles."""
    parts = "".join(
        f'<object id="{k}"><components>{2 * f"""<component objectid="{k + 1}"/>"""}</components>'
        "</object>"
        for k in range(1, depth)
    )
    return f'{parts}<object id="{depth}">{TRIANGLE}</object>'


def polygon_ply(corners):
    """Three vertices and a polygon of these, in binary."""
    text = ply("binary_little_endian", vertices(3) + faces(1).replace("uchar int", "int uchar"))
    corner = bytes([0, 1, 2]) * (corners // 3) + bytes(corners % 3)
    return text[:-64] + np.eye(3, dtype="<f4").tobytes() + np.int32(corners).tobytes() + corner


def many_attributes():
    """A hundred of them, in one and the same part of a GLB file."""
    count = 100_000
    tree = scene([{"mesh": 0}], count - 1) | {
        "buffers": [{"byteLength": 12 * count}],
        "bufferViews": [{"buffer": 0, "byteLength": 12 * count}],
    }
    names = {f"_A{number}": 0 for number in range(100)}
    tree["meshes"] = [{"primitives": [{"attributes": {"POSITION": 0, "COLOR_0": 0} | names}]}]
    return glb(tree, np.random.default_rng(0).random((count, 3)).astype("<f4").tobytes())


CORNERS = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"
SOLID = (
    "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
    "endloop\nendfacet\nendsolid\n"
)
REFUSED = "RejectedError"
CONTAINED = "RejectedError|a mesh"  # either will do, if it takes no more than it may

# Content, or what makes it, and what comes of it.
BOMBS = {
    "faces.ply": (ply("binary_little_endian", vertices(3) + faces(BILLION)), REFUSED),
    "ascii.ply": (ply("ascii", vertices(BILLION) + faces(1)), REFUSED),
    "negative.ply": (ply("ascii", vertices(-BILLION) + faces(1)), REFUSED),
    "endless.ply": (b"ply\n" + b"comment \n" * 20_000, REFUSED),
    "lines.ply": (ply("ascii", vertices(3) + faces(1)) + b"\n" * 9_000_000, REFUSED),
    "faces.stl": (bytes(80) + struct.pack("<I", BILLION) + bytes(100), REFUSED),
    "solids.stl": (b"solid\nendsolid\n" * 20_000, REFUSED),
    "faces.off": (f"OFF\n3 {BILLION} 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n".encode(), "truncated"),
    "vertices.off": (f"OFF\n{BILLION} 1 0\n0 0 0\n".encode(), "truncated"),
    "face.obj": (f"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 {BILLION} 3\n".encode(), REFUSED),
    "bare.glb": (glb({"bufferViews": [], "accessors": [accessor(10**7)] * 9}), REFUSED),
    "large.glb": (glb({"bufferViews": [], "accessors": [accessor(BILLION)]}), REFUSED),
    "views.glb": (
        glb(
            {"bufferViews": [{"buffer": 0, "byteLength": MEGABYTE}] * 1000, "accessors": []},
            bytes(MEGABYTE),
        ),
        REFUSED,
    ),
    "shared.glb": (
        glb(
            {
                "bufferViews": [{"buffer": 0, "byteLength": MEGABYTE}],
                "accessors": [accessor(MEGABYTE // 12, bufferView=0)] * 1000,
            },
            bytes(MEGABYTE),
        ),
        REFUSED,
    ),
    "nodes.glb": (glb(scene([{"mesh": 0}] * 20_000)), REFUSED),
    "twice.glb": (glb(scene([{"children": [1, 1]}, {"children": [2, 2]}, {"mesh": 0}])), REFUSED),
    "around.glb": (glb(scene([{"children": [1]}, {"children": [0], "mesh": 0}])), REFUSED),
    "nested.glb": (glb({"extras": 1}).replace(b'"extras": 1', b"[" * 11), REFUSED),
    "zeros.3mf": (
        lambda: packed(**{"3D__3dmodel_model": " " * (300 * MEGABYTE)}),
        "bytes unpacked",
    ),
    "doubled.3mf": (plate(doubled(40)), CONTAINED),
    "deep.3mf": (plate(doubled(150)), CONTAINED),
    "around.3mf": (
        plate('<object id="1"><components><component objectid="1"/></components></object>'),
        REFUSED,
    ),
    "twice.3mf": (
        assembled("3D__part_model", model(f'<object id="2">{TRIANGLE}</object>'), 20_000),
        CONTAINED,
    ),
    "laughs.3mf": (
        plate(
            f'<object id="1">{TRIANGLE}&b;</object>',
            '<!DOCTYPE model [<!ENTITY a "ha"><!ENTITY b "&a;&a;">]>',
        ),
        CONTAINED,
    ),
    "blank.obj": (b"\n" * 20_000_000, REFUSED),
    "plain.obj": (b"v 0 0 0\n" * 4_200_000 + b"f 1 2 3\n", "4,200,000 vertices"),
    "tabs.obj": (b"v\t0 0 0\n" * 4_200_000 + b"f\t1 2 3\n", REFUSED),
    "faces.obj": (b"v 0 0 0\n" * 3 + b"f\t1 2 3\n" * 4_200_000, REFUSED),
    "polygon.off": (b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n30000" + b" 0 1 2" * 10_000, CONTAINED),
    "polygon.ply": (
        ply("ascii", vertices(3) + faces(1)) + b"\n0 0 0\n1 0 0\n30000" + b" 0 1 2" * 10_000,
        CONTAINED,
    ),
    "words.stl": (lambda: b"solid\nvertex" + b" 1" * 100_000_000 + b"\nendsolid\n", REFUSED),
    "attributes.glb": (
        glb(
            {
                "bufferViews": [{"buffer": 0, "byteLength": MEGABYTE, "byteStride": 1}],
                "accessors": [accessor(MEGABYTE // 2, bufferView=0, type="MAT4")] * 50,
            },
            bytes(MEGABYTE),
        ),
        REFUSED,
    ),
    "other.3mf": (
        assembled("3D__part_xml", model(f'<object id="2">{MANY_FACES}</object>'), 900),
        CONTAINED,
    ),
    "outside.3mf": (assembled("3D__part_xml", MANY_FACES, 900), CONTAINED),
    "doctype.3mf": (assembled("3D__part_xml", "<!DOCTYPE mesh>" + TRIANGLE), CONTAINED),
    "inside.3mf": (plate(f'<object id="1">{TRIANGLE}<object id="2"/></object>'), CONTAINED),
    "elements.3mf": (lambda: packed(**{"3D__3dmodel_model": "<m>" + "<a/>" * 40_000_000}), REFUSED),
    "encoding.3mf": (
        plate(f'<object id="1">{TRIANGLE}</object>', '<?xml version="1.0" encoding="cp037"?>'),
        CONTAINED,
    ),
    "wide.3mf": (packed(**{"3D__3dmodel_model": model("").encode("utf-16")}), REFUSED),
    "other.txt": (b"solid", "allowed endings"),
    "bomb.zip": (packed(a_stl="solid"), "allowed endings"),
    "polygon.obj": (CORNERS + "f" + " 1/1 2/1\\\n 3/1" * 10_000 + "\n", CONTAINED),
    "polygons.obj": (lambda: CORNERS + ("f" + " 1 2 3" * 3_000 + "\n") * 500, REFUSED),
    "mixed.obj": (CORNERS + "f 1 2 3 1\nf" + " 1/1 2/1 3/1" * 10_000 + "\n", CONTAINED),
    "comment.obj": (CORNERS + "# a comment\nf" + " 1/1 2/1 3/1" * 10_000 + "\n", CONTAINED),
    "triangles.obj": (lambda: CORNERS + "f 1 2 3\n" * 4_200_000, "4,200,000 faces"),
    "long.obj": (lambda: CORNERS + "f" + " 1 2 3" * 1_390_000 + "\n", "4,169,998 faces"),
    "empty.obj": (lambda: "v \n" * 2_790_000, REFUSED),
    "faces2.stl": (lambda: bytes(80) + struct.pack("<I", 4_200_000) + bytes(210_000_000), "faces"),
    "bodies.stl": (SOLID * 20_000, CONTAINED),
    "list.ply": (lambda: polygon_ply(50_000_000), CONTAINED),
    "attributes2.glb": (many_attributes, CONTAINED),
}


def content(name):
    """The bytes of a file of `BOMBS`."""
    made = BOMBS[name][0]
    made = made() if callable(made) else made
    return made.encode() if isinstance(made, str) else made


def whole_file(ending):
    return BALL.export(file_type=ending[1:])


def whole_files():
    texts = {ending: whole_file(ending) for ending in ENDINGS}
    texts[".ply ascii"] = BALL.export(file_type="ply", encoding="ascii")
    texts[".stl ascii"] = BALL.export(file_type="stl_ascii")
    return {name: data.encode() if isinstance(data, str) else data for name, data in texts.items()}


WHOLE = whole_files()
WORDS = [b"", b"0", b"-1", b"1e309", b"nan", b"4294967295", b"99999999999"]
WORDS += [b"\x00", b"\xff" * 4, b"\n"]


@st.composite
def damaged(draw):
    """A file with some places overwritten, cut out, repeated, or cut short."""
    name = draw(st.sampled_from(sorted(WHOLE)))
    data = bytearray(WHOLE[name])
    for _ in range(draw(st.integers(1, 6))):
        start = draw(st.integers(0, max(len(data) - 1, 0)) | st.integers(0, min(400, len(data))))
        length = draw(st.sampled_from([0, 1, 2, 4, 8, 40, 4000]))
        piece = draw(st.sampled_from(WORDS) | st.binary(max_size=8))
        data[start : start + length] = piece * draw(st.sampled_from([1, 1, 1, 50]))
    return name.split()[0], bytes(data[: draw(st.sampled_from([len(data), len(data) // 2])) or 1])

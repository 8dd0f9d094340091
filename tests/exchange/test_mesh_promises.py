"""Files of strangers: bombs, files that name others, and random ones."""

import io
import json
import math
import struct
import tracemalloc
import zipfile

import numpy as np
import pytest
import trimesh
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from egad.errors import RejectedError
from egad.exchange.bounds import MOST_UNPACKED
from egad.exchange.folders import ENDINGS
from egad.exchange.meshes import read_mesh
from egad.exchange.threemf import CORE

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


FACE = '<triangle v1="0" v2="1" v3="2"/>'
TRIANGLE = (
    '<mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="1" y="0" z="0"/>'
    '<vertex x="0" y="1" z="0"/></vertices><triangles><triangle v1="0" v2="1" v3="2"/>'
    "</triangles></mesh>"
)


def doubled(depth):
    """Objects, each made of two of the next: 2^depth triangles."""
    parts = "".join(
        f'<object id="{k}"><components>{2 * f"""<component objectid="{k + 1}"/>"""}</components>'
        "</object>"
        for k in range(1, depth)
    )
    return f'{parts}<object id="{depth}">{TRIANGLE}</object>'


# large ones are made by the test that reads them
BOMBS = {
    "faces.ply": (ply("binary_little_endian", vertices(3) + faces(BILLION)), "1,000,000,000"),
    "ascii.ply": (ply("ascii", vertices(BILLION) + faces(1)), "1,000,000,000"),
    "negative.ply": (ply("ascii", vertices(-BILLION) + faces(1)), "-1,000,000,000"),
    "endless.ply": (b"ply\n" + b"comment \n" * 20_000, "no end"),
    "lines.ply": (ply("ascii", vertices(3) + faces(1)) + b"\n" * 9_000_000, "lines"),
    "faces.stl": (bytes(80) + struct.pack("<I", BILLION) + bytes(100), "not a readable|no faces"),
    "solids.stl": (b"solid\nendsolid\n" * 20_000, "bodies"),
    "faces.off": (f"OFF\n3 {BILLION} 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n".encode(), "cut short"),
    "vertices.off": (f"OFF\n{BILLION} 1 0\n0 0 0\n".encode(), "not a readable"),
    "face.obj": (f"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 {BILLION} 3\n".encode(), "readable|not there"),
    "bare.glb": (glb({"bufferViews": [], "accessors": [accessor(10**7)] * 9}), "values"),
    "large.glb": (glb({"bufferViews": [], "accessors": [accessor(BILLION)]}), "values"),
    "views.glb": (
        glb(
            {"bufferViews": [{"buffer": 0, "byteLength": MEGABYTE}] * 1000, "accessors": []},
            bytes(MEGABYTE),
        ),
        "in views of the file",
    ),
    "shared.glb": (
        glb(
            {
                "bufferViews": [{"buffer": 0, "byteLength": MEGABYTE}],
                "accessors": [accessor(MEGABYTE // 12, bufferView=0)] * 1000,
            },
            bytes(MEGABYTE),
        ),
        "as often as it is used",
    ),
    "nodes.glb": (glb(scene([{"mesh": 0}] * 20_000)), "nodes and placed parts"),
    "twice.glb": (
        glb(scene([{"children": [1, 1]}, {"children": [2, 2]}, {"mesh": 0}])),
        "hangs from two others",
    ),
    "around.glb": (glb(scene([{"children": [1]}, {"children": [0], "mesh": 0}])), "from two"),
    "nested.glb": (glb({"extras": 1}).replace(b'"extras": 1', b"[" * 11), "not a readable"),
    "zeros.3mf": (
        lambda: packed(**{"3D__3dmodel_model": " " * (300 * MEGABYTE)}),
        "bytes unpacked",
    ),
    "doubled.3mf": (plate(doubled(40)), "as placed"),
    "deep.3mf": (plate(doubled(150)), "nested too deep"),
    "around.3mf": (
        plate('<object id="1"><components><component objectid="1"/></components></object>'),
        "made of themselves",
    ),
    "twice.3mf": (
        packed(
            **{
                "3D__3dmodel_model": model(
                    '<object id="1"><components>'
                    + '<component objectid="2" path="/3D/part.model"/>' * 20_000
                    + "</components></object>"
                ),
                "3D__part_model": model(f'<object id="2">{TRIANGLE}</object>'),
            }
        ),
        "as placed",
    ),
    "laughs.3mf": (
        plate(
            f'<object id="1">{TRIANGLE}&b;</object>',
            '<!DOCTYPE model [<!ENTITY a "ha"><!ENTITY b "&a;&a;">]>',
        ),
        "DOCTYPE",
    ),
    "blank.obj": (b"\n" * 20_000_000, "20,000,000 lines"),
    "plain.obj": (b"v 0 0 0\n" * 4_200_000 + b"f 1 2 3\n", "4,200,000 vertices"),
    "tabs.obj": (b"v\t0 0 0\n" * 4_200_000 + b"f\t1 2 3\n", "4,200,000 vertices"),
    "faces.obj": (b"v 0 0 0\n" * 3 + b"f\t1 2 3\n" * 4_200_000, "4,200,000 faces"),
    "polygon.off": (b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n30000" + b" 0 1 2" * 10_000, "30,001 words"),
    "polygon.ply": (
        ply("ascii", vertices(3) + faces(1)) + b"\n0 0 0\n1 0 0\n30000" + b" 0 1 2" * 10_000,
        "30,001 words",
    ),
    "words.stl": (lambda: b"solid\nvertex" + b" 1" * 100_000_000 + b"\nendsolid\n", "words"),
    "attributes.glb": (
        glb(
            {
                "bufferViews": [{"buffer": 0, "byteLength": MEGABYTE, "byteStride": 1}],
                "accessors": [accessor(MEGABYTE // 2, bufferView=0, type="MAT4")] * 50,
            },
            bytes(MEGABYTE),
        ),
        "bytes of values",
    ),
    "other.3mf": (
        packed(
            **{
                "3D__3dmodel_model": model(
                    '<object id="1"><components>'
                    + '<component objectid="2" path="/3D/part.xml"/>' * 900
                    + "</components></object>"
                ),
                "3D__part_xml": model(
                    f'<object id="2">{TRIANGLE.replace(FACE, FACE * 20_000)}</object>'
                ),
            }
        ),
        "18,0.* vertices and faces",
    ),
    "outside.3mf": (
        packed(
            **{
                "3D__3dmodel_model": model(
                    '<object id="1"><components>'
                    + '<component objectid="2" path="/3D/part.xml"/>' * 900
                    + "</components></object>"
                ),
                "3D__part_xml": TRIANGLE.replace(FACE, FACE * 20_000),
            }
        ),
        "18,0.* vertices and faces",
    ),
    "doctype.3mf": (
        packed(
            **{
                "3D__3dmodel_model": model(
                    '<object id="1"><components><component objectid="2" path="/3D/part.xml"/>'
                    "</components></object>"
                ),
                "3D__part_xml": "<!DOCTYPE mesh>" + TRIANGLE,
            }
        ),
        "DOCTYPE",
    ),
    "inside.3mf": (plate(f'<object id="1">{TRIANGLE}<object id="2"/></object>'), "object is in"),
    "elements.3mf": (
        lambda: packed(**{"3D__3dmodel_model": "<m>" + "<a/>" * 40_000_000}),
        "elements",
    ),
    "encoding.3mf": (
        plate(f'<object id="1">{TRIANGLE}</object>', '<?xml version="1.0" encoding="cp037"?>'),
        "not UTF-8",
    ),
    "wide.3mf": (packed(**{"3D__3dmodel_model": model("").encode("utf-16")}), "not UTF-8"),
    "other.txt": (b"solid", "allowed endings"),
    "bomb.zip": (packed(a_stl="solid"), "allowed endings"),
}


def unpacked(name, content):
    """Bytes of what is in a zip that is small enough to be looked at."""
    if not name.endswith(".3mf"):
        return 0
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        size = sum(entry.file_size for entry in archive.infolist())
    return size if size <= MOST_UNPACKED else 0


@pytest.mark.parametrize("name", BOMBS)
def test_what_promises_too_much_is_refused_before_memory_is_taken(tmp_path, name):
    content, reason = BOMBS[name]
    content = content() if callable(content) else content
    path = tmp_path / name
    path.write_bytes(content)
    tracemalloc.start()
    try:
        with pytest.raises(RejectedError, match=reason):
            read_mesh(path, "m")
        assert tracemalloc.get_traced_memory()[1] < 20 * MEGABYTE + 4 * max(
            len(content), unpacked(name, content)
        )
    finally:
        tracemalloc.stop()


def test_a_file_that_is_too_large_is_not_read(tmp_path):
    with (tmp_path / "hole.stl").open("wb") as file:
        file.truncate(2 << 30)
    with pytest.raises(RejectedError, match="2,147,483,648 bytes"):
        read_mesh(tmp_path / "hole.stl", "m")


@pytest.mark.parametrize("more", ["", "f 1 2 3 1\n", "# a comment\n"])
def test_polygons_of_an_obj_file_have_a_bound(tmp_path, more):
    corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\n" + more
    (tmp_path / "a.obj").write_text(corners + "f" + " 1 2 3" * 3_000 + "\n")
    assert len(read_mesh(tmp_path / "a.obj", "m").faces) in (8_998, 9_000)
    (tmp_path / "a.obj").write_text(corners + "f" + " 1/1 2/1\\\n 3/1" * 10_000 + "\n")
    with pytest.raises(RejectedError, match="30,000 corners of a face"):
        read_mesh(tmp_path / "a.obj", "m")
    (tmp_path / "a.obj").write_text(corners + ("f" + " 1 2 3" * 3_000 + "\n") * 500)
    with pytest.raises(RejectedError, match="triangles"):
        read_mesh(tmp_path / "a.obj", "m")


def test_polygons_of_a_binary_ply_file_have_a_bound(tmp_path):
    text = ply("binary_little_endian", vertices(3) + faces(1).replace("uchar int", "int uchar"))
    head = text[:-64] + np.eye(3, dtype="<f4").tobytes()
    for count, bound in ((300, None), (50_000_000, "values in lists")):
        (tmp_path / "a.ply").write_bytes(
            head + np.int32(count).tobytes() + bytes([0, 1, 2]) * (count // 3) + bytes(count % 3)
        )
        if bound is None:
            assert len(read_mesh(tmp_path / "a.ply", "m").faces) == count - 2
        else:
            with pytest.raises(RejectedError, match=bound):
                read_mesh(tmp_path / "a.ply", "m")


def test_attributes_of_a_glb_file_take_no_memory(tmp_path):
    """A hundred of them, in one and the same part of the file."""
    count = 100_000
    tree = scene([{"mesh": 0}], count) | {
        "buffers": [{"byteLength": 12 * count}],
        "bufferViews": [{"buffer": 0, "byteLength": 12 * count}],
    }
    names = {f"_A{number}": 0 for number in range(100)}
    tree["meshes"] = [{"primitives": [{"attributes": {"POSITION": 0, "COLOR_0": 0} | names}]}]
    tree["accessors"][0]["count"] = 99_999
    corners = np.random.default_rng(0).random((count, 3)).astype("<f4")
    (tmp_path / "a.glb").write_bytes(glb(tree, corners.tobytes()))
    tracemalloc.start()
    try:
        assert len(read_mesh(tmp_path / "a.glb", "m").faces) == 33_333
        assert tracemalloc.get_traced_memory()[1] < 60 * MEGABYTE
    finally:
        tracemalloc.stop()


OTHERS = "the ball of another folder\n"


@pytest.mark.parametrize("where", ["../secret", "/dev/zero", "file:///dev/zero", "/secret"])
def test_no_other_file_is_read(tmp_path, where):
    """With one that never ends, it would not end."""
    folder = tmp_path / "meshes"
    folder.mkdir()
    (tmp_path / "secret").write_text(OTHERS)
    where = where.replace("/secret", f"{tmp_path}/secret") if where == "/secret" else where
    BALL.export(folder / "a.obj")
    text = (folder / "a.obj").read_text()
    (folder / "a.obj").write_text(f"mtllib {where}\nusemtl paint\nmap_Kd {where}\n{text}")
    BALL.export(folder / "b.ply", encoding="ascii")
    text = (folder / "b.ply").read_text()
    (folder / "b.ply").write_text(
        text.replace("\nelement", f"\ncomment TextureFile {where}\nelement", 1)
    )
    entity = f'<!DOCTYPE model [<!ENTITY a SYSTEM "{where}">]>'
    (folder / "c.3mf").write_bytes(plate(f'<object id="1" name="&a;">{TRIANGLE}</object>', entity))
    named = scene([{"mesh": 0}]) | {"buffers": [{"byteLength": 64, "uri": where}]}
    (folder / "d.glb").write_bytes(glb(named))
    assert read_mesh(folder / "a.obj", "m").volume == pytest.approx(BALL.volume)
    assert read_mesh(folder / "b.ply", "m").volume == pytest.approx(BALL.volume, rel=1e-6)
    for name in ("c.3mf", "d.glb"):
        with pytest.raises(RejectedError, match=r"DOCTYPE|names another file"):
            read_mesh(folder / name, "m")


def test_many_materials_make_one_mesh(tmp_path):
    """Apart they would take the vertices once for each."""
    lines = [f"v {x} {y} {z}" for x, y, z in BALL.vertices.tolist()]
    for number, face in enumerate((BALL.faces + 1).tolist()):
        lines += [f"usemtl m{number}", f"g part{number} # a comment", "# usemtl none"]
        lines.append("f " + " ".join(f"{corner}//{corner}" for corner in face))
    (tmp_path / "ball.obj").write_text("\r\n".join(lines))
    mesh = read_mesh(tmp_path / "ball.obj", "m")
    assert mesh.is_volume
    assert np.array_equal(mesh.faces, BALL.faces)


def read_or_reject(folder, ending, data):
    """What any file must do: be a mesh with finite coordinates, or be refused."""
    path = folder / f"any{ending}"
    path.write_bytes(data)
    try:
        mesh = read_mesh(path, "m")
    except RejectedError:
        return
    assert np.isfinite(mesh.vertices).all()
    assert mesh.area > 0
    assert mesh.faces.max() < len(mesh.vertices)


def whole_file(ending):
    return BALL.export(file_type=ending[1:])


def whole_files():
    texts = {ending: whole_file(ending) for ending in ENDINGS}
    texts[".ply ascii"] = BALL.export(file_type="ply", encoding="ascii")
    texts[".stl ascii"] = BALL.export(file_type="stl_ascii")
    return {name: data.encode() if isinstance(data, str) else data for name, data in texts.items()}


WHOLE = whole_files()
WORDS = [
    b"",
    b"0",
    b"-1",
    b"1e309",
    b"nan",
    b"4294967295",
    b"99999999999",
    b"\x00",
    b"\xff" * 4,
    b"\n",
]


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


def fuzz(examples):
    return settings(
        max_examples=examples,
        derandomize=examples < 1000,
        deadline=None,
        database=None,
        suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
    )


@fuzz(150)
@given(damaged())
def test_damaged_files_are_meshes_or_refused(tmp_path, file):
    read_or_reject(tmp_path, *file)


@fuzz(150)
@given(st.sampled_from(ENDINGS), st.binary(max_size=400))
def test_random_bytes_are_meshes_or_refused(tmp_path, ending, data):
    read_or_reject(tmp_path, ending, data)


LEAF = st.none() | st.integers(-2, 9) | st.sampled_from([BILLION, math.pi, "VEC3", "data:", "x"])
KEYS = ["buffer", "byteLength", "count", "type", "mesh", "children", "POSITION", "indices", "nodes"]
JSON = st.recursive(
    LEAF, lambda some: st.lists(some, max_size=3) | st.dictionaries(st.sampled_from(KEYS), some)
)


@fuzz(60)
@given(st.dictionaries(st.sampled_from([*scene([]), "images", "scene", "extensions"]), JSON))
def test_any_structure_of_a_glb_file_is_a_mesh_or_refused(tmp_path, changes):
    read_or_reject(tmp_path, ".glb", glb(scene([{"mesh": 0}]) | changes))


@pytest.mark.slow
@fuzz(30_000)
@given(damaged())
def test_very_many_damaged_files_are_meshes_or_refused(tmp_path, file):
    read_or_reject(tmp_path, *file)

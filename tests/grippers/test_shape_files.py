"""Files of collision shapes: where they are found, and formats that MuJoCo does not read."""

import os
import re
import struct
from pathlib import Path

import numpy as np
import pytest
import trimesh
from described_hands import PANDA, box_urdf

from egad.errors import UserError
from egad.grippers.description import description_files
from egad.grippers.reading import read_model
from egad.grippers.shape_files import find_file

FINGER = np.array(PANDA["finger"])


@pytest.fixture(scope="module")
def boxes(tmp_path_factory):
    return read_model(box_urdf(tmp_path_factory.mktemp("hand") / "boxes.urdf"))


def hand_with(folder: Path, file: str, scale: str = "") -> Path:
    """The boxes with a file in the place of the boxes of the fingers."""
    old = '<box size="{} {} {}"/>'.format(*FINGER)
    mesh = f'<mesh filename="{file}" {scale}/>'
    return box_urdf(folder / "hand.urdf", changes={old: mesh})


def text_stl(mesh: trimesh.Trimesh) -> str:
    """A mesh as STL in text."""
    found = mesh.export(file_type="stl_ascii")
    return found if isinstance(found, str) else found.decode()


def check(found, boxes, tolerance: float = 1e-7) -> None:
    """Whether a hand has the openings and corners of the boxes."""
    np.testing.assert_allclose(found.openings, boxes.openings, atol=tolerance)
    for shapes, expected in zip(found.points(0.05), boxes.points(0.05), strict=True):
        for points, corners in zip(shapes, expected, strict=True):
            order = [np.lexsort(np.round(each, 5).T) for each in (points, corners)]
            np.testing.assert_allclose(points[order[0]], corners[order[1]], atol=1e-6)


@pytest.mark.parametrize("change", ["", "crlf", "bom", "upper", "millimetres"])
def test_stl_in_text_is_read(tmp_path, boxes, change):
    scale = 1000 if change == "millimetres" else 1
    text = text_stl(trimesh.creation.box(FINGER * scale))
    data = {"crlf": text.replace("\n", "\r\n"), "upper": text.upper()}.get(change, text).encode()
    (tmp_path / "finger.stl").write_bytes((b"\xef\xbb\xbf" if change == "bom" else b"") + data)
    path = hand_with(tmp_path, "finger.stl", 'scale="0.001 0.001 0.001"' if scale > 1 else "")
    check(read_model(path), boxes)


def test_a_binary_file_that_begins_like_text_is_read(tmp_path, boxes):
    data = trimesh.creation.box(FINGER).export(file_type="stl")
    (tmp_path / "finger.STL").write_bytes(b"solid part" + data[10:])
    check(read_model(hand_with(tmp_path, "finger.STL")), boxes)


def test_a_mesh_is_read_again_when_it_has_changed(tmp_path):
    """Otherwise the same model comes back."""
    mesh = tmp_path / "finger.stl"
    path = hand_with(tmp_path, mesh.name)
    for width in (0.02, 0.03):
        trimesh.creation.box((FINGER[0], width, FINGER[2])).export(mesh)
        os.utime(mesh, ns=(0, round(1e9 * width)))
        found = read_model(path)
        assert np.ptp(found.pad[:, 1]) == pytest.approx(width)
        assert read_model(path) is found


def test_more_faces_than_mujoco_reads_become_a_convex_hull(tmp_path, boxes):
    """A box of 12 * 4^7 = 196608 faces, and one of them divided further."""
    mesh = trimesh.creation.box(FINGER)
    for _ in range(7):
        mesh = mesh.subdivide()
    mesh = mesh.subdivide(np.arange(2000))
    assert len(mesh.faces) > 200_000
    mesh.export(tmp_path / "finger.stl")
    check(read_model(hand_with(tmp_path, "finger.stl")), boxes)


def test_mjcf_is_read_with_meshes_in_text_and_without_names(tmp_path):
    """The shape of an arm may be missing."""
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "finger.stl").write_text(text_stl(trimesh.creation.box(FINGER)))
    trimesh.creation.icosphere(radius=0.004).export(tmp_path / "meshes" / "ball.stl")
    sides = "".join(
        f"""<body name="{name}"><joint name="{name}" type="slide" axis="{way} 0 0" range="0 0.04"/>
        <geom type="mesh" mesh="finger" pos="{way * FINGER[0] / 2} 0 0.02"/>
        <geom type="mesh" mesh="ball" contype="0" conaffinity="0"/></body>"""
        for name, way in (("left", -1), ("right", 1))
    )
    path = tmp_path / "hand.xml"
    path.write_text(f"""<mujoco><compiler meshdir="meshes"/>
    <asset><mesh file="finger.stl"/><mesh file="ball.stl"/></asset>
    <worldbody><body name="arm"><geom type="mesh" mesh="arm"/>
      <body name="palm"><joint name="turn" range="-1 1"/>
      <geom type="box" size="0.05 0.03 0.01" pos="0 0 -0.02"/>{sides}</body>
    </body></worldbody>
    <asset><mesh name="arm" file="missing.stl"/></asset>
    <equality><joint joint1="right" joint2="left"/></equality></mujoco>""")
    found = read_model(path)
    assert found.openings[[0, -1]] == pytest.approx([0, 0.08], abs=1e-7)
    assert [len(link.shapes) for link in found.links] == [1, 1, 1]
    assert {each.name for each in description_files(path)} == {"hand.xml", "finger.stl", "ball.stl"}


def box_text():
    return text_stl(trimesh.creation.box(FINGER))


BROKEN = {
    "is flat": b"solid a\nendsolid a\n",
    "it is neither a binary file nor text": b"hello world\n" * 20,
    "it is truncated: its header says 12": trimesh.creation.box(FINGER).export(file_type="stl")[
        :-60
    ],
    "it is truncated: .* facets begin": box_text()[:700].encode(),
    "is flat or damaged": bytes(80) + struct.pack("<I12fHI", 1, *np.eye(4)[:, :3].ravel(), 0, 0),
}


@pytest.mark.parametrize("why", BROKEN)
def test_a_damaged_stl_file_is_refused_with_its_link(tmp_path, why):
    (tmp_path / "finger.stl").write_bytes(BROKEN[why])
    words = r"a mesh of the link left cannot be used: .*finger\.stl.*"
    with pytest.raises(UserError, match=words + why):
        read_model(hand_with(tmp_path, "finger.stl"))


@pytest.mark.parametrize("ending", ["ply", "off", "glb"])
def test_formats_that_mujoco_does_not_know_are_read(tmp_path, boxes, ending):
    trimesh.creation.box(FINGER).export(tmp_path / f"finger.{ending}")
    check(read_model(hand_with(tmp_path, f"finger.{ending}")), boxes)


def test_another_format_is_refused_with_its_name(tmp_path):
    (tmp_path / "finger.step").write_text("ISO-10303-21;")
    words = r"link left cannot be used: .*finger\.step is not STL, OBJ, PLY, .*convert it"
    with pytest.raises(UserError, match=words):
        read_model(hand_with(tmp_path, "finger.step"))


def collada(vertices, faces, *, unit: str = "", place: str = "") -> str:
    """A Collada file with one shape in two nodes, whose upward axis is y."""
    numbers = " ".join(str(number) for number in np.ravel(vertices))
    corners = " ".join(str(number) for number in np.ravel(faces))
    return f"""<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
  <asset>{unit}<up_axis>Y_UP</up_axis></asset>
  <library_geometries><geometry id="shape"><mesh>
    <source id="places">
      <float_array id="numbers" count="{np.size(vertices)}">{numbers}</float_array>
      <technique_common><accessor source="#numbers" count="{len(vertices)}" stride="3">
        <param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/>
      </accessor></technique_common></source>
    <vertices id="corners"><input semantic="POSITION" source="#places"/></vertices>
    <triangles count="{len(faces)}"><input semantic="VERTEX" source="#corners" offset="0"/>
      <p>{corners}</p></triangles>
  </mesh></geometry></library_geometries>
  <library_visual_scenes><visual_scene id="scene"><node id="outer">{place}
    <node id="inner"><instance_geometry url="#shape"/></node>
  </node></visual_scene></library_visual_scenes>
  <scene><instance_visual_scene url="#scene"/></scene>
</COLLADA>"""


@pytest.mark.parametrize("unit", [1.0, 0.001])
def test_a_collada_shape_has_its_unit_and_place_and_no_upward_axis(tmp_path, boxes, unit):
    box = trimesh.creation.box(FINGER / unit / 2)
    stated = "" if unit == 1 else f'<unit name="u" meter="{unit}"/>'
    shift = FINGER / unit
    text = collada(
        box.vertices - shift,
        box.faces,
        unit=stated,
        place="<scale>2 2 2</scale><translate>{} {} {}</translate>".format(*shift),
    )
    (tmp_path / "finger.dae").write_text(text)
    check(read_model(hand_with(tmp_path, "finger.dae")), boxes)


BROKEN_COLLADA = {
    "<COLLADA/>": "damaged or has no Collada scene",
    collada(np.eye(3), [[0, 1, 2]]).replace(
        'scene url="#scene"', "no"
    ): "damaged or has no Collada",
    collada(np.eye(3), [[0, 1, 9]]): "not readable as Collada: Indexes .* beyond",
    "solid": "not readable as Collada: XML Parsing Error",
    collada(np.eye(3), [[0, 1, 2]]).replace("float_array", "reals"): "not readable .* No array",
    collada([[0, 0, 0]], []): "a Collada file without faces",
}


@pytest.mark.parametrize("text", BROKEN_COLLADA)
def test_a_collada_file_without_shapes_is_refused_with_what_to_do(tmp_path, text):
    (tmp_path / "finger.dae").write_text(text)
    words = rf"finger\.dae is {BROKEN_COLLADA[text]}.*; convert it to STL or OBJ"
    with pytest.raises(UserError, match=words) as refused:
        read_model(hand_with(tmp_path, "finger.dae"))
    assert not re.search(r"NoneType|Dae|<string>", str(refused.value))


def package(folder: Path, name: str) -> Path:
    """A package of ROS with a mesh of a finger."""
    (folder / "meshes").mkdir(parents=True)
    (folder / "package.xml").write_text(f"<package>\n  <name> {name} </name>\n</package>")
    trimesh.creation.box(FINGER).export(folder / "meshes" / "finger.stl")
    return folder


@pytest.mark.parametrize(
    ("variable", "folder", "listed"),
    [
        ("ROS_PACKAGE_PATH", "src/stack/maker", "src"),
        ("ROS_PACKAGE_PATH", "src/stack/maker-1.2", "src"),
        ("ROS_PACKAGE_PATH", "src/maker", "src/maker"),
        ("AMENT_PREFIX_PATH", "install/share/maker", "install"),
    ],
)
def test_packages_are_found_where_ros_looks(tmp_path, monkeypatch, variable, folder, listed):
    """In any of the folders that are listed, under its own name or another one."""
    path = hand_with(tmp_path, "package://maker/meshes/finger.stl")
    monkeypatch.delenv("ROS_PACKAGE_PATH", raising=False)
    monkeypatch.delenv("AMENT_PREFIX_PATH", raising=False)
    root = tmp_path / "elsewhere"
    maker = package(root / folder, "maker")
    with pytest.raises(UserError, match=r"link left is missing: .*package maker is in none of"):
        read_model(path)
    assert description_files(path) == [path]
    monkeypatch.setenv(variable, os.pathsep.join([str(tmp_path / "none"), str(root / listed)]))
    assert find_file("package://maker/meshes/finger.stl", path) == maker / "meshes/finger.stl"
    assert set(description_files(path)) == {path, maker / "meshes" / "finger.stl"}
    with pytest.raises(UserError, match=r"looked for .*maker.*no\.stl"):
        find_file("package://maker/no.stl", path)


def test_a_checkout_of_another_name_is_the_package_that_it_says(tmp_path):
    maker = package(tmp_path / "maker-main", "maker")
    path = maker / "urdf" / "hand.urdf"
    for scheme in ("package", "model"):
        file = find_file(f"{scheme}://maker/meshes/finger.stl", path)
        assert file == maker / "meshes" / "finger.stl"


def test_linked_packages_are_found_and_links_in_circles_end(tmp_path, monkeypatch):
    """As a workspace links to checkouts elsewhere; one link leads back to the workspace."""
    maker = package(tmp_path / "checkouts" / "maker", "maker")
    workspace = tmp_path / "workspace" / "src"
    workspace.mkdir(parents=True)
    (workspace / "stack").symlink_to(tmp_path / "checkouts")
    (workspace / "renamed").symlink_to(maker)
    (workspace / "round").symlink_to(workspace)
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(workspace))
    for name in ("maker", "renamed"):
        found = find_file(f"package://{name}/meshes/finger.stl", tmp_path / "hand.urdf")
        assert found == maker / "meshes/finger.stl"


def test_uris_of_files_are_read(tmp_path, boxes):
    folder = package(tmp_path / "my package", "maker")
    uri = (folder / "meshes" / "finger.stl").as_uri()
    assert "%20" in uri
    check(read_model(hand_with(tmp_path, uri)), boxes)
    with pytest.raises(UserError, match=r"no\.stl \(looked for .*my package/no\.stl"):
        find_file((folder / "no.stl").as_uri(), tmp_path / "hand.urdf")

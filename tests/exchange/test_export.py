"""Exports from Python: files read again by other libraries."""

from typing import get_args

import h5py
import numpy as np
import pytest
import trimesh
import yaml
from described_hands import box_urdf

import egad
from egad.errors import UserError
from egad.exchange import ObjectFormat

BLOCK = trimesh.creation.box((0.2, 0.1, 0.15))
SHEET = trimesh.Trimesh([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]], [[0, 1, 2]])
FACTOR = 0.8 * 0.08 / 0.1  # the smallest side becomes 80 % of the opening


def test_acronym_files_hold_the_object_and_its_grasps(tmp_path):
    found = egad.export(
        {"block": BLOCK, "sheet": SHEET}, "acronym", "panda", tmp_path / "out", grasps=8
    )
    assert (found.labels, list(found.left_out)) == (["block"], ["sheet"])
    assert repr(found).startswith(f"{tmp_path}/out: 1 exported; left out: sheet: ")
    written = [str(path.relative_to(found.folder)) for path in found.files]
    assert written == ["block.h5", "meshes/block.obj"]
    with h5py.File(tmp_path / "out/block.h5") as file:
        mesh = trimesh.load_mesh(tmp_path / "out" / file["object/file"][()].decode())
        assert np.sort(mesh.extents) == pytest.approx(FACTOR * np.array([0.1, 0.15, 0.2]))
        assert file["object/volume"][()] == pytest.approx(mesh.volume)
        poses = file["grasps/transforms"][()]
    assert poses.shape == (8, 4, 4)
    assert np.linalg.det(poses[:, :3, :3]) == pytest.approx(np.ones(8))


def test_isaac_grasp_needs_a_gripper_with_joints(tmp_path):
    with pytest.raises(UserError, match="'panda' is made of boxes"):
        egad.export({"block": BLOCK}, "isaac_grasp", "panda", tmp_path / "out")
    assert not (tmp_path / "out").exists()
    hand = egad.Gripper.from_file(box_urdf(tmp_path / "hand.urdf"))
    assert (
        list(
            egad.export({"block": BLOCK}, "isaac_grasp", hand, tmp_path / "out", grasps=2).left_out
        )
        == []
    )
    grasps = yaml.safe_load((tmp_path / "out/block.yaml").read_text())["grasps"]
    assert len(grasps) == 2
    assert (tmp_path / "out/meshes/block.obj").exists()


@pytest.mark.parametrize("style", get_args(ObjectFormat))
def test_formats_of_simulators_have_files_of_each_object_that_is_solid(tmp_path, style):
    if style == "usd":
        pytest.importorskip("pxr")
    found = egad.export({"block": BLOCK, "sheet": SHEET}, style, "panda", tmp_path / "out")
    assert list(found.left_out) == ["sheet"]
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert names
    assert {name.partition(".")[0] for name in names} == {"block"}


@pytest.mark.parametrize("style", ["acronym", "simulation", "obj", "stl"])
def test_a_mesh_is_wound_outwards_and_an_open_one_left_out(tmp_path, style):
    inverted = BLOCK.copy()
    inverted.invert()
    tray = trimesh.Trimesh(BLOCK.vertices, BLOCK.faces[2:], process=False)
    given = {"inverted": inverted, "tray": tray}
    assert list(egad.export(given, style, "panda", tmp_path / "out", grasps=2).left_out) == ["tray"]
    files = [p for p in (tmp_path / "out").rglob("*") if p.suffix in (".obj", ".stl")]
    assert files
    for path in files:
        assert trimesh.load_mesh(path).volume > 0
        assert "tray" not in path.name


def test_a_wrong_name_is_told_before_anything_is_made(tmp_path):
    with pytest.raises(UserError, match="object 'a/b' cannot be exported under this name"):
        egad.export({"no_mesh": None, "a/b": BLOCK}, "obj", "panda", tmp_path / "out")


def test_what_is_there_is_not_lost_and_mistakes_are_told(tmp_path):
    (tmp_path / "mine.txt").touch()
    with pytest.raises(UserError, match="is not empty, and its files would be lost; name a new"):
        egad.export({"block": BLOCK}, "obj", "panda", tmp_path)
    with pytest.raises(UserError, match="format 'arconym' is not known; did you mean acronym"):
        egad.export({"block": BLOCK}, "arconym", "panda", tmp_path / "out")
    with pytest.raises(UserError, match="there are no objects"):
        egad.export({}, "obj", "panda", tmp_path / "out")
    with pytest.raises(UserError, match="is a file; name a folder"):
        egad.export({"block": BLOCK}, "obj", "panda", tmp_path / "mine.txt")
    with pytest.raises(UserError, match="grasps is 0"):
        egad.export({"block": BLOCK}, "acronym", "panda", tmp_path / "out", grasps=0)
    for style in ("acronym", "obj"):
        with pytest.raises(UserError, match="seed is 'x'"):
            egad.export({"block": BLOCK}, style, "panda", tmp_path / "out", seed="x")
    with pytest.raises(UserError, match="rule 'papr' is not known; did you mean paper"):
        egad.export({"block": BLOCK}, "obj", "panda", tmp_path / "out", rule="papr")
    assert not (tmp_path / "out").exists()

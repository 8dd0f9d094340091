"""The conditions of the table that takes trials closer to the robot."""

import runpy
import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh

from egad.bench import TrialProtocol
from egad.detectors import Grasp, Intrinsics, View, camera_above
from egad.grippers import GRIPPERS, Gripper

FOLDER = Path(__file__).parent


@pytest.fixture(scope="module")
def program():
    sys.path.append(str(FOLDER))
    return runpy.run_path(str(FOLDER / "cell_causes.py"))


def test_every_change_of_a_condition_has_a_meaning(program):
    """Nothing is misspelt, and constants of egad exist under their names."""
    others = {"crop_up", "width", "deeper", "rule"}
    known = {*TrialProtocol.model_fields, *Gripper.model_fields, *others}
    for changes in program["CONDITIONS"].values():
        for name in changes.keys() - known:
            module, _, constant = name.rpartition(".")
            assert hasattr(sys.modules[module], constant)


def test_grasps_deviate_as_a_condition_says(program):
    """The crop is higher; the width is cut only at the end; fingertips stay above the table."""
    seen = []

    def detect(view, gripper, _):
        seen.append(view.depth.shape)
        return [Grasp((0, 0, 0.03), 0.0, 0.09 if gripper.opening > 0.09 else 0.0, 0.01, 1.0)]

    view = View(np.ones((480, 640)), Intrinsics.spanning(640, 480, 75), camera_above(0.6))
    for deeper, tip in ((0.009, 0.011), (0.021, 0.005)):
        changes = {"crop_up": 40, "width": 0.8, "deeper": deeper}
        (grasp,) = program["AsOnTheRobot"](detect, changes)(view, GRIPPERS["egad_75mm"], None)
        assert (round(grasp.width, 6), round(grasp.tip, 6)) == (0.072, tip)
    assert seen == [(400, 640)] * 2


def test_published_objects_fill_a_grid(program, tmp_path):
    """One object for each cell, each once, in the place of its label."""
    for letter in "ABEHLPSVX":
        for complexity in (0, 5, 10, 15, 20, 25):
            path = tmp_path / f"{letter}{complexity:02d}_0.ply"
            trimesh.creation.box((10, 20, 30)).export(path)
    targets = list(program["published"](tmp_path))
    assert len({each.id for each in targets}) == 49
    assert {each.label for each in targets} == {f"{row}{k}" for row in "ABCDEFG" for k in range(7)}
    assert targets[0].id == "B00_0"  # the middle of row A lies in B
    assert targets[0].mesh().extents.max() == pytest.approx(0.03)


def test_network_of_the_robot_is_read(tmp_path):
    """Maps have the size of the image; a network of zeros answers with its biases."""
    pytest.importorskip("torch")
    h5py = pytest.importorskip("h5py")
    sizes = {"conv2d": ((9, 1, 32), (5, 32, 16), (3, 16, 8))}
    sizes["conv2d_transpose"] = ((3, 8, 8), (5, 16, 8), (9, 32, 16))
    layers = {f"{k}_{i}": size for k, each in sizes.items() for i, size in enumerate(each, 1)}
    layers |= {f"{name}_out": (2, 32, 1) for name in ("pos", "cos", "sin", "width")}
    with h5py.File(tmp_path / "model.hdf5", "w") as file:
        for i, (name, (side, first, second)) in enumerate(layers.items()):
            group = file.create_group(f"model_weights/{name}/{name}")
            group["kernel:0"] = np.zeros((side, side, first, second), np.float32)
            filters = first if "transpose" in name else second
            group["bias:0"] = np.full(filters, i, np.float32)
    read = runpy.run_path(str(FOLDER / "robot_network.py"))["keras_network"]
    maps = read(tmp_path / "model.hdf5")(np.zeros((300, 300), np.float32))
    assert maps.shape == (4, 300, 300)
    assert [np.unique(each).tolist() for each in maps] == [[6], [7], [8], [9]]

"""The adapters of published detectors without their networks: frames, points, bad environments."""

import subprocess
import sys
from pathlib import Path
from unittest.mock import MagicMock

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from egad.grippers import GRIPPERS

EXAMPLES = Path(__file__).parents[2] / "examples"
PANDA = GRIPPERS["panda"]
ADAPTERS = ("contact_graspnet", "edge_grasp")


@pytest.fixture(params=ADAPTERS)
def adapter(request, monkeypatch):
    return load(request.param, monkeypatch)


def load(name, monkeypatch):
    monkeypatch.syspath_prepend(str(EXAMPLES))
    return __import__(name)


def random_pose(rng):
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = Rotation.random(rng=rng).as_matrix(), rng.normal(size=3)
    return pose


def test_contact_graspnet_has_the_same_fingertips(monkeypatch):
    """Its control points: the middle of the fingertips of a Panda is 112.2 mm along z, x closes."""
    module, rng = load("contact_graspnet", monkeypatch), np.random.default_rng(0)
    theirs = random_pose(rng)
    ours = module.in_egad(theirs[None], PANDA.finger_width)[0]
    for side in (-0.04, 0.04):
        expected = theirs @ [side, 0, 0.0584 + 0.0538, 1]  # joint of the fingers, their length
        found = ours @ [side, 0, PANDA.kind.span[1], 1]
        assert found == pytest.approx(expected, abs=1e-9)


def test_edge_grasp_has_the_same_fingertips(monkeypatch):
    """In hand.urdf the fingers slide along y; PyBullet moves the center of mass, 40 mm along z."""
    module, rng = load("edge_grasp", monkeypatch), np.random.default_rng(0)
    theirs = random_pose(rng)
    ours = module.in_egad(theirs[None], PANDA.finger_width)[0]
    assert np.linalg.det(ours[:3, :3]) == pytest.approx(1)
    for side in (-0.04, 0.04):
        expected = theirs @ [0, side, 0.0584 + 0.0538 - 0.04, 1]
        found = ours @ [side, 0, PANDA.kind.span[1], 1]
        assert found == pytest.approx(expected, abs=1e-9)


def test_edge_grasp_closes_on_the_contact(monkeypatch):
    """The side of a box: the approach point 12 mm above a contact, 20 mm beside it."""
    module = load("edge_grasp", monkeypatch)
    approach, contact = np.array([0.1, 0.0, 0.05]), np.array([0.12, 0.0, 0.038])
    along, up = np.array([[1.0, 0, 0]]), np.array([[0, 0, 1.0]])
    poses = module.hand_frames(approach[None], along, up, np.array([0.012]))
    (pose,) = module.in_egad(poses, PANDA.finger_width)
    x, y, z = np.linalg.inv(pose)[:3] @ [*contact, 1]
    assert (abs(x), y) == pytest.approx((0.02, 0), abs=1e-9)
    assert 0 < PANDA.kind.span[1] - z == pytest.approx(0.0072)  # the fingertips go 7 mm deeper
    assert pose[:3, 2] == pytest.approx([0, 0, -1])


def test_edge_grasp_estimates_normals_of_a_noisy_ball(monkeypatch):
    module, rng = load("edge_grasp", monkeypatch), np.random.default_rng(0)
    outward = rng.normal(size=(4000, 3))
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    points = [0, 0, 0.06] + 0.05 * outward + rng.normal(0, 0.0005, outward.shape)
    stray = np.array([[0.0, 0.0, 0.2]])
    found, normals = module.prepare(np.vstack([points, stray]), np.vstack([outward, [[0, 0, 1]]]))
    assert 500 < len(found) < 4000
    assert found[:, 2].max() < 0.12
    away = (found - [0, 0, 0.06]) / np.linalg.norm(found - [0, 0, 0.06], axis=1, keepdims=True)
    assert np.median(np.einsum("ni,ni->n", away, normals)) > 0.99


def test_contact_graspnet_sees_the_table_around_but_not_under_the_objects(monkeypatch):
    module, rng = load("contact_graspnet", monkeypatch), np.random.default_rng(0)
    objects = rng.uniform([-0.02, -0.02, 0.01], [0.02, 0.02, 0.05], (500, 3))
    points, of_objects = module.scene(objects, rng)
    table = points[~of_objects]
    assert (table[:, 2] == 0).all()
    assert (points[of_objects][:, 2] > 0).all()
    assert np.abs(table[:, :2]).max(axis=1).min() > 0.015


def test_without_points_there_are_no_grasps(monkeypatch):
    for name, kind in (("contact_graspnet", "ContactGraspNet"), ("edge_grasp", "EdgeGrasp")):
        detect = object.__new__(getattr(load(name, monkeypatch), kind))
        cloud = {"points": np.zeros((0, 3)), "normals": np.zeros((0, 3))}
        rng = np.random.default_rng(0)
        assert [len(each) for each in detect({"cloud": cloud}, PANDA.model_dump(), rng)] == [0] * 3


def test_a_missing_repository_is_told(monkeypatch, tmp_path):
    module = load("edge_grasp", monkeypatch)
    monkeypatch.setattr(module, "REPOSITORY", tmp_path / "nowhere")
    for name in ("torch", "torch_geometric", "torch_cluster", "torch_scatter"):
        monkeypatch.setitem(sys.modules, name, MagicMock())
    with pytest.raises(SystemExit, match=r"nowhere is missing; edge_grasp\.py says how to get it"):
        module.EdgeGrasp()


@pytest.mark.parametrize("name", ADAPTERS)
def test_a_missing_environment_is_told(name, tmp_path):
    """PyTorch cannot be imported."""
    (tmp_path / "torch.py").write_text("raise ImportError('No module named torch')")
    code = f"import runpy, sys; sys.path.insert(0, {str(tmp_path)!r}); " + (
        f"sys.path.insert(1, {str(EXAMPLES)!r}); "
        f"runpy.run_path({str(EXAMPLES / name)!r} + '.py', run_name='__main__')"
    )
    ended = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False
    )
    assert (ended.returncode, ended.stdout) == (1, "")
    assert ended.stderr.splitlines()[-1] == (
        f"{name}: the environment lacks a package (No module named torch); {name}.py says how to "
        "set it up"
    )

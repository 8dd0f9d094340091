"""Labels of GraspNet-1Billion, against rotations of graspnetAPI's own `loadGrasp`."""

import logging

import numpy as np
import pytest

import egad
from egad.errors import UserError
from egad.exchange import grasp_files

POINTS = np.array([[0.1, 0.2, 0.3], [-0.01, 0.02, 0.0]], np.float32)
SHAPE = (2, 300, 12, 4)
# point, view, angle, depth of the candidates below; then rotations of `GraspGroup`, row by row
CANDIDATES = [(0, 0, 0, 0), (0, 77, 5, 3), (1, 150, 11, 1), (1, 299, 7, 2)]
FRICTION = [0.3, 1.0, 0.1, 0.6]
ROTATIONS = [
    [-0.0816, 0.0, 0.9967, 0.0, -1.0, 0.0, 0.9967, 0.0, 0.0816],
    [0.7432, -0.5331, 0.4043, 0.4627, -0.027, -0.8861, 0.4833, 0.8456, 0.2266],
    [0.2784, 0.928, 0.2477, 0.9605, -0.2681, -0.0751, -0.0033, 0.2588, -0.9659],
    [-0.0214, -0.0024, 0.9998, 0.0787, 0.9969, 0.004, -0.9967, 0.0788, -0.0211],
]


def labels(folder, **changed):
    offsets, scores = np.zeros((*SHAPE, 3), np.float32), np.full(SHAPE, -1, np.float32)
    offsets[..., 0] = np.arange(12)[:, None] * np.pi / 12
    offsets[..., 1], offsets[..., 2] = [0.01, 0.02, 0.03, 0.04], 0.06
    collision = np.zeros(SHAPE, bool)
    for candidate, friction in zip(CANDIDATES, FRICTION, strict=True):
        scores[candidate] = friction
    collision[CANDIDATES[2]] = True
    known = {"points": POINTS, "offsets": offsets, "scores": scores, "collision": collision}
    known |= changed
    np.savez_compressed(folder / "007_labels.npz", **known)
    return folder / "007_labels.npz"


def test_candidates_with_a_friction_coefficient_are_those_of_graspnet_api(tmp_path, caplog):
    with caplog.at_level(logging.INFO):
        found = egad.read_grasps(labels(tmp_path))
    assert "4 of 28,800 candidates have a friction coefficient" in caplog.text
    assert "the hand collides at 1 of them" in caplog.text
    theirs = np.reshape(ROTATIONS, (4, 3, 3))
    points, depths = POINTS[[0, 0, 1, 1]], np.array([0.01, 0.04, 0.02, 0.03])
    assert found.poses[:, :3, [2, 0, 1]] == pytest.approx(theirs, abs=2e-4)  # single precision
    expected = points + depths[:, None] * theirs[:, :, 0]
    assert found.poses[:, :3, 3] == pytest.approx(expected, abs=1e-5)
    assert found.widths == pytest.approx(0.06)
    assert found.source_score == pytest.approx(1.1 - np.array(FRICTION), abs=1e-6)
    assert found.source_success == pytest.approx([np.nan, np.nan, 0, np.nan], nan_ok=True)


def test_a_limit_of_friction_chooses_and_too_many_grasps_name_it(tmp_path, monkeypatch):
    path = labels(tmp_path)
    chosen = egad.read_grasps(path, max_friction=0.3)
    assert chosen.source_score == pytest.approx([0.8, 1.0], abs=1e-6)
    assert chosen.source_success.tolist() == [1, 0]  # the second is in collision
    monkeypatch.setattr(grasp_files, "MAX_GRASPS", 3)
    monkeypatch.setattr("egad.exchange.reading.limited", lambda function, *args: function(*args))
    asked = r"it has 4 grasps; at most 3: give a lower `max_friction`.*0.1: 1.* 0.3: 2.* 1: 4"
    with pytest.raises(UserError, match=asked):
        egad.read_grasps(path)


def test_blocks_of_an_archive_are_the_array(tmp_path, monkeypatch):
    monkeypatch.setattr(grasp_files, "BLOCK", 7)
    values = np.arange(60, dtype=np.float16).reshape(5, 4, 3)
    np.savez_compressed(tmp_path / "a.npz", values=values)
    archive = grasp_files.NpzFile(tmp_path / "a.npz")
    blocks = list(archive.blocks("values", (5, 4, 3), 3))
    assert [first for first, _ in blocks] == [0, 7, 14]
    assert (np.concatenate([block for _, block in blocks]) == values.reshape(20, 3)).all()


@pytest.mark.parametrize(
    ("changed", "said", "message"),
    [
        ({"scores": np.full(SHAPE, -1.0)}, {}, "it has 0 grasps"),
        ({"scores": np.full(SHAPE, np.nan)}, {}, "scores that are not finite"),
        ({"scores": np.ones((2, 300, 12))}, {}, r"its scores has the shape \(2, 300, 12\)"),
        ({"offsets": np.full((*SHAPE, 3), np.nan)}, {}, "a pose that is not finite"),
        ({"points": np.zeros((3, 3))}, {}, r"shape \(2, 300, 12, 4\); allowed: \(3, 300"),
        ({}, {"max_friction": -1}, "max_friction is -1; allowed: a finite number, above 0"),
        ({}, {"format": "poses"}, "not a file of poses: it has points, offsets, scores"),
        ({}, {"gripper": "cup_30mm"}, "graspnet is not for cup_30mm, which has a suction"),
    ],
)
def test_other_labels_are_refused(tmp_path, changed, said, message):
    with pytest.raises(UserError, match=message):
        egad.read_grasps(labels(tmp_path, **changed), **said)


def test_other_files_have_no_friction(tmp_path):
    np.save(tmp_path / "a.npy", np.eye(4)[None])
    with pytest.raises(UserError, match="it has no friction coefficients, which `max_friction`"):
        egad.read_grasps(tmp_path / "a.npy", max_friction=0.4, frame="x z", depth=0, units="m")

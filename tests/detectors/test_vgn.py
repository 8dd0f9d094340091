"""VGN: its input, its answers; EGAD_VGN names the file of its published weights."""

import os
import pickle

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from egad.detectors import (
    DepthCamera,
    Intrinsics,
    Tsdf,
    Vgn,
    cameras_around,
    encode,
    fuse,
    wanted_input,
)
from egad.errors import UserError
from egad.grippers import GRIPPERS, finger_span

HAND = GRIPPERS["panda"]
WEIGHTS = os.environ.get("EGAD_VGN")
CAMERA = Intrinsics(320, 240, 208.0, (159.5, 119.5))


def fused(mesh):
    eye = DepthCamera(mesh)
    poses = cameras_around(np.array([0, 0, -0.05]), 6, 0.6, np.radians(30))
    views = [eye.render(np.eye(4), CAMERA, pose) for pose in poses]
    return fuse(views, np.array([-0.15, -0.15, -0.05]), 0.3, 40)


def test_the_grid_is_0_where_nothing_is_known_and_far_from_surfaces():
    distances = np.zeros((40, 40, 40), np.float32)
    distances[:, 0, 0] = np.linspace(-1, 1, 40)
    weights = np.ones_like(distances)
    weights[0, 1, 0] = 0
    grid = encode(Tsdf(distances, weights, np.zeros(3), 0.0075, 0.03))
    assert grid[0, 1, 0] == 0  # not seen
    assert grid[1, 1, 0] == 0.5  # on a surface
    assert grid[0, 0, 0] == 0
    assert grid[-1, 0, 0] == 0  # free space, far away
    np.testing.assert_allclose(grid[1:-1, 0, 0], np.linspace(0, 1, 40)[1:-1], atol=1e-6)
    assert grid.dtype == np.float32


@pytest.mark.parametrize("weights", [None, "no/such/file.pth"])
def test_missing_weights_are_named(weights):
    with pytest.raises(UserError, match=r"vgn_conv\.pth"):
        Vgn(weights)


VOXEL, CORNER, WHERE = 0.0075, np.array([-0.15, -0.15, -0.05]), (20, 10, 15)
TURN = Rotation.from_euler("xyz", [2.5, 0.3, 0.4])


def asked(width, hand):
    """The grasps of a network whose quality has one peak and whose width is the same everywhere."""
    answer = np.zeros((6, 40, 40, 40), np.float32)
    answer[5] = width
    answer[0][WHERE] = 30  # so much that it is still above the threshold when smoothed
    answer[1:5] = TURN.as_quat()[:, None, None, None]
    distances = np.full((40, 40, 40), 0.5, np.float32)  # free space everywhere
    detect = Vgn.__new__(Vgn)
    detect._infer, detect._threshold = lambda _: answer, 0.9
    grid = Tsdf(distances, np.ones_like(distances), CORNER, VOXEL, 4 * VOXEL)
    return detect(grid, hand, np.random.default_rng(0))


def test_colliding_grasps_come_last(observation):
    """The box is 4 cm wide: a finger of a hand that is 3 cm off is inside it."""
    tsdf = observation.tsdf
    down = Rotation.from_euler("x", np.pi).as_quat()
    answer = np.zeros((6, 40, 40, 40), np.float32)
    answer[5], answer[1:5] = 5, down[:, None, None, None]
    tip = np.array([0, 0, 0.02])  # VGN's origin is 5 cm above it
    for along, quality in ((0.0, 20), (0.03, 30)):
        where = np.rint((tip + np.array([0, along, 0.05]) - tsdf.corner) / tsdf.voxel).astype(int)
        answer[0][tuple(where)] = quality
    found = {}
    for avoid in (False, True):
        detect = Vgn.__new__(Vgn)
        detect._infer, detect._threshold, detect._avoids_collisions = lambda _: answer, 0.1, avoid
        assert wanted_input(detect) == ("observation" if avoid else "tsdf")
        found[avoid] = detect(observation if avoid else tsdf, HAND, np.random.default_rng(0))
    free, last = found[True].poses[:, 1, 3]
    assert abs(free) < 0.004
    assert abs(last - 0.03) < 0.004
    np.testing.assert_array_equal(found[False].poses, found[True].poses[::-1])
    before, after = found[False].scores[::-1], found[True].scores
    np.testing.assert_allclose(after / before, [1, 0.1])


def test_the_threshold_is_that_of_the_weights_or_that_of_vgn(tmp_path):
    torch = pytest.importorskip("torch")
    weights = pytest.importorskip("egad.detectors.weights")
    network = pytest.importorskip("egad.detectors.vgn_network").new_vgn(0)
    torch.save(network.state_dict(), tmp_path / "published.pth")
    assert Vgn(str(tmp_path / "published.pth"))._threshold == 0.9
    path = tmp_path / "trained.safetensors"
    for notes, threshold in (({}, 0.9), ({"threshold": 0.6}, 0.6), ([], 0.9)):
        weights.write(network, path, notes)
        assert Vgn(str(path))._threshold == threshold
        assert Vgn(str(path), 0.7)._threshold == 0.7
    for wrong in ("high", float("nan"), 1.0):
        weights.write(network, path, {"threshold": wrong})
        with pytest.raises(UserError, match=r"its threshold is .*; allowed: above 0 and below 1"):
            Vgn(str(path))


def test_a_peak_of_the_quality_becomes_a_pose():
    """VGN's origin lies 5 cm before the fingertips, ours between the pads; it closes along y."""
    (pose,), (width,), (score,) = asked(5, HAND)
    x, y, z = TURN.as_matrix().T
    np.testing.assert_allclose(pose[:3, :3].T, [y, -x, z], atol=1e-6)
    tip = CORNER + np.array(WHERE) * VOXEL + 0.05 * z
    np.testing.assert_allclose(pose[:3, 3] + finger_span(HAND)[1] * z, tip, atol=1e-6)
    assert width == HAND.opening
    assert score > 0.9


@pytest.mark.parametrize(
    ("hand", "most"),
    [("panda", 9.33), ("egad_75mm", 9.33), ("robotiq_2f_140", 9.33 * 14 / 8)],
)
def test_widths_up_to_what_the_hand_opens_are_proposed(hand, most):
    """For VGN's hand and narrower ones the bound is VGN's, 7 cm; a wider hand is not held to it."""
    for width, count in ((1.3, 0), (1.4, 1), (0.999 * most, 1), (1.001 * most, 0)):
        assert len(asked(width, GRIPPERS[hand]).poses) == count, width


@pytest.mark.slow
@pytest.mark.skipif(WEIGHTS is None, reason="EGAD_VGN names no file")
@pytest.mark.parametrize("turn", [0.0, 0.6, 1.5])
def test_a_block_is_grasped_across(turn):
    """The frame is ours: x closes, and the pads are where the block is."""
    pytest.importorskip("torch")
    block = trimesh.creation.box((0.03, 0.1, 0.06)).apply_translation((0, 0, 0.03))
    block.apply_transform(trimesh.transformations.rotation_matrix(turn, [0, 0, 1]))
    detect = pickle.loads(pickle.dumps(Vgn(WEIGHTS)))  # noqa: S301 (as other processes get it)
    assert wanted_input(detect) == "tsdf"
    grasps = detect(fused(block), HAND, np.random.default_rng(0))
    assert len(grasps.poses) > 0
    best = grasps.poses[0]
    np.testing.assert_allclose(best[:3, :3].T @ best[:3, :3], np.eye(3), atol=1e-5)
    across = [np.cos(turn), np.sin(turn), 0]
    # The network errs by up to 30 degrees; if our x were its y, it would be 90.
    assert abs(best[:3, 0] @ across) > np.cos(np.pi / 4)
    assert abs(best[:3, 3] @ across) < 0.02
    assert best[2, 2] < -0.5
    tip = best[:3, 3] + finger_span(HAND)[1] * best[:3, 2]
    assert 0 < tip[2] < 0.06

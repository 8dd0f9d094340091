import numpy as np
import pytest
from autolab_core import RigidTransform

from egad.grasps.poses import (
    PANDA_REACH,
    dexnet_angles,
    dexnet_configurations,
    dexnet_frames,
    hand_poses,
    panda_poses,
)


@pytest.fixture
def grasps():
    """Centers, axes and approaches at right angles to them; some axes are vertical."""
    rng = np.random.default_rng(4)
    axes = rng.normal(size=(50, 3))
    axes[:2] = [[0, 0, 1], [0, 0, -1]]
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    approaches = np.cross(axes, rng.normal(size=(50, 3)))
    approaches /= np.linalg.norm(approaches, axis=1, keepdims=True)
    return rng.normal(size=(50, 3)), axes, approaches


def test_a_pose_closes_along_x_and_approaches_along_z(grasps):
    centers, axes, approaches = grasps
    poses = hand_poses(*grasps)
    for pose, center, axis, approach in zip(poses, centers, axes, approaches, strict=True):
        rigid = RigidTransform(pose[:3, :3], pose[:3, 3], "hand", "object")  # checks the rotation
        assert rigid.x_axis == pytest.approx(axis)
        assert rigid.z_axis == pytest.approx(approach)
        assert rigid.translation == pytest.approx(center)


def test_fingertips_of_the_panda_hand_are_ours(grasps):
    poses = hand_poses(*grasps)
    ours = poses @ [0, 0, 0.008, 1]
    assert panda_poses(poses, 0.008) @ [0, 0, PANDA_REACH, 1] == pytest.approx(ours)


def turn_about_y(angle):
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([[cos, 0, -sin], [0, 1, 0], [sin, 0, cos]])  # as Dex-Net has it


def test_dexnet_angles_give_the_approach_back(grasps):
    _, axes, approaches = grasps
    frames, angles = dexnet_frames(axes), dexnet_angles(axes, approaches)
    for frame, angle, axis, approach in zip(frames, angles, axes, approaches, strict=True):
        rigid = RigidTransform(frame @ turn_about_y(angle), np.zeros(3), "grasp", "obj")
        assert rigid.x_axis == pytest.approx(approach)
        assert rigid.y_axis == pytest.approx(axis)


def test_the_frame_of_dexnet_lies_flat(grasps):
    frames = dexnet_frames(grasps[1])
    assert frames[:, 2, 0] == pytest.approx(0)
    assert frames[:2, :, 0] == pytest.approx(np.array([[1, 0, 0], [1, 0, 0]]))


def test_a_configuration_has_ten_numbers(grasps):
    found = dexnet_configurations(*grasps, 0.05)
    assert found.shape == (50, 10)
    assert found[:, :6] == pytest.approx(np.hstack(grasps[:2]))
    assert found[:, [6, 8, 9]] == pytest.approx(np.tile([0.05, 0, 0], (50, 1)))

"""Poses of the hand in the frames of other programs."""

import numpy as np
import pytest
from autolab_core import RigidTransform
from hand_frames import hand_frames

from egad.exchange.grasps import dexnet
from egad.exchange.grasps.acronym import PANDA_REACH, panda_poses
from egad.grasps import hand_poses


@pytest.fixture
def grasps():
    return hand_frames()


def test_fingertips_of_the_panda_hand_are_ours(grasps):
    poses = hand_poses(*grasps)
    ours = poses @ [0, 0, 0.008, 1]
    assert panda_poses(poses, 0.008) @ [0, 0, PANDA_REACH, 1] == pytest.approx(ours)


def turn_about_y(angle):
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([[cos, 0, -sin], [0, 1, 0], [sin, 0, cos]])  # as Dex-Net has it


def test_dexnet_angles_give_the_approach_back(grasps):
    _, axes, approaches = grasps
    frames, angles = dexnet.frames(axes), dexnet.angles(axes, approaches)
    for frame, angle, axis, approach in zip(frames, angles, axes, approaches, strict=True):
        rigid = RigidTransform(frame @ turn_about_y(angle), np.zeros(3), "grasp", "obj")
        assert rigid.x_axis == pytest.approx(approach)
        assert rigid.y_axis == pytest.approx(axis)


def test_the_frame_of_dexnet_lies_flat(grasps):
    frames = dexnet.frames(grasps[1])
    assert frames[:, 2, 0] == pytest.approx(0)
    assert frames[:2, :, 0] == pytest.approx(np.array([[1, 0, 0], [1, 0, 0]]))


def test_a_configuration_has_ten_numbers(grasps):
    found = dexnet.configurations(*grasps, 0.05)
    assert found.shape == (50, 10)
    assert found[:, :6] == pytest.approx(np.hstack(grasps[:2]))
    assert found[:, [6, 8, 9]] == pytest.approx(np.tile([0.05, 0, 0], (50, 1)))

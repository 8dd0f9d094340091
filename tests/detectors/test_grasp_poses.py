"""Grasps in any direction are checked before they are tried."""

import numpy as np
import pytest

from egad.detectors import Grasp, GraspPoses, choose
from egad.detectors.base import best_poses, poses_of
from egad.grippers import GRIPPERS, finger_span
from egad.tables.outcomes import Outcome

HAND = GRIPPERS["panda"]


def raised(height=0.1):
    pose = np.diag([1.0, -1.0, -1.0, 1.0])
    pose[2, 3] = height
    return pose


def changed(row, column, value):
    pose = raised()
    pose[row, column] = value
    return pose


@pytest.mark.parametrize(
    ("pose", "width", "score", "outcome"),
    [
        (raised(), 0.05, 1.0, None),
        (raised(), HAND.opening, -3.0, None),
        (changed(0, 3, np.nan), 0.05, 1.0, Outcome.NOT_FINITE),
        (raised(), np.inf, 1.0, Outcome.NOT_FINITE),
        (raised(), 0.05, np.nan, Outcome.NOT_FINITE),
        (changed(0, 0, 1.1), 0.05, 1.0, Outcome.NOT_RIGID),
        (changed(0, 0, -1.0), 0.05, 1.0, Outcome.NOT_RIGID),  # a mirror image
        (changed(3, 0, 0.5), 0.05, 1.0, Outcome.NOT_RIGID),
        (np.zeros((4, 4)), 0.05, 1.0, Outcome.NOT_RIGID),
        (raised(), HAND.opening + 0.001, 1.0, Outcome.TOO_WIDE),
        (raised(), -0.001, 1.0, Outcome.TOO_WIDE),
        (raised(finger_span(HAND)[1] - 0.001), 0.05, 1.0, Outcome.BELOW_TABLE),
    ],
)
def test_what_the_hand_cannot_do_has_a_name(pose, width, score, outcome):
    assert Grasp.of_pose(pose, width, score).infeasibility(HAND) == outcome


def test_the_best_grasp_that_can_be_done_is_tried():
    poses = np.stack([raised(), raised(0.2), raised(-1), raised(0.3)])
    grasps = GraspPoses(poses, np.array([1.0, 0.05, 0.05, 0.05]), np.array([4.0, 2, 3, 2]))
    best = choose(grasps, HAND)
    assert isinstance(best, Grasp)
    assert (best.pose[2, 3], best.quality) == (0.2, 2.0)


def test_without_any_the_flaw_of_the_most_promising_is_told():
    poses = np.stack([raised(-1), raised(), raised()])
    grasps = GraspPoses(poses, np.array([0.05, 1.0, 0.05]), np.array([1.0, 2.0, np.nan]))
    assert choose(grasps, HAND) == Outcome.TOO_WIDE
    assert choose(poses_of(([], [], [])), HAND) == Outcome.NO_GRASP


def test_the_best_come_first():
    grasps = GraspPoses(
        np.stack([raised(n) for n in range(5)]), np.arange(5.0), np.array([1, 5, 2, 5, 0.0])
    )
    np.testing.assert_array_equal(best_poses(grasps, 3).widths, [1, 3, 2])


@pytest.mark.parametrize(
    "answer",
    [
        (np.eye(4), [0.05], [1.0]),
        (np.eye(4)[None], [0.05, 0.05], [1.0]),
        (np.eye(4)[None], 0.05, [1.0]),
        (np.eye(3)[None], [0.05], [1.0]),
    ],
)
def test_arrays_of_other_shapes_are_refused(answer):
    with pytest.raises((ValueError, TypeError)):
        poses_of(answer)


def test_a_grasp_from_above_is_a_pose_with_the_same_fingertips():
    grasp = Grasp((0.1, 0.2, 0.05), 0.7, 0.04, 0.02, 0.9)
    posed = grasp.as_pose(HAND)
    pose = posed.pose
    np.testing.assert_allclose(pose[:3, :3].T @ pose[:3, :3], np.eye(3), atol=1e-12)
    np.testing.assert_allclose(pose[:3, 0], [np.cos(0.7), np.sin(0.7), 0])
    np.testing.assert_allclose(pose[:3, 2], [0, 0, -1])
    tip = pose[:3, 3] + finger_span(HAND)[1] * pose[:3, 2]
    np.testing.assert_allclose(tip, [0.1, 0.2, grasp.tip])
    assert (posed.width, posed.quality) == (0.04, 0.9)
    assert posed.infeasibility(HAND) is None
    back = posed.from_above(HAND)
    assert (back.tip, back.angle) == pytest.approx((grasp.tip, grasp.angle))

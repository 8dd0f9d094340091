"""Grasps, from above and in any direction, are checked before they are tried."""

from dataclasses import replace

import numpy as np
import pytest

from egad.detectors import Grasp, GraspPoses, best_grasp, choose
from egad.detectors.base import MAX_GRASPS, best_poses, poses_of, rank_grasps
from egad.grippers import GRIPPERS, finger_span
from egad.tables.outcomes import Outcome

HAND, PANDA = GRIPPERS["egad_75mm"], GRIPPERS["panda"]
FINE = Grasp((0.0, 0.0, 0.02), 0.0, 0.05, 0.01, 0.5)
NAN = float("nan")


@pytest.mark.parametrize(
    ("change", "flaw"),
    [
        ({}, None),
        ({"width": 0.075}, None),
        ({"width": 0.0}, None),
        ({"depth": 0.02}, None),
        ({"width": 0.0751}, "too_wide"),
        ({"width": -0.001}, "too_wide"),
        ({"depth": 0.021}, "below_table"),
        ({"center": (0.0, 0.0, -0.01)}, "below_table"),
        ({"center": (0.0, NAN, 0.02)}, "not_finite"),
        ({"angle": NAN}, "not_finite"),
        ({"width": float("inf")}, "not_finite"),
        ({"quality": NAN}, "not_finite"),
    ],
)
def test_flaws(change, flaw):
    assert replace(FINE, **change).infeasibility(HAND) == flaw


def test_the_best_is_of_the_highest_quality_that_the_hand_can_do():
    poorer = replace(FINE, quality=0.3)
    too_wide = replace(FINE, width=0.2, quality=0.9)
    nowhere = replace(FINE, center=(0.0, NAN, 0.02), quality=0.8)
    unsure = replace(FINE, quality=float("inf"))
    assert best_grasp([poorer, too_wide, FINE, nowhere, unsure], HAND) == FINE
    assert best_grasp([nowhere, too_wide], HAND) == "too_wide"
    assert best_grasp([unsure], HAND) == "not_finite"
    assert best_grasp([], HAND) == "no_grasp"


@pytest.mark.parametrize("count", [0, 1, 7, 80])
def test_candidates_are_ranked_as_one_would_one_by_one(count):
    rng = np.random.default_rng(count)
    center, axis = rng.normal(size=(count, 3)), rng.normal(size=(count, 2))
    (width, depth), quality = rng.random((2, count)), rng.integers(5, size=count) / 4
    slow = [
        Grasp(tuple(center[i]), np.arctan2(axis[i, 1], axis[i, 0]), width[i], depth[i], quality[i])
        for i in range(count)
    ]
    slow.sort(key=lambda grasp: -grasp.quality)
    assert rank_grasps(center, axis, width, depth, quality) == slow[:MAX_GRASPS]


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
        (raised(), PANDA.opening, -3.0, None),
        (changed(0, 3, np.nan), 0.05, 1.0, Outcome.NOT_FINITE),
        (raised(), np.inf, 1.0, Outcome.NOT_FINITE),
        (raised(), 0.05, np.nan, Outcome.NOT_FINITE),
        (changed(0, 0, 1.1), 0.05, 1.0, Outcome.NOT_RIGID),
        (changed(0, 0, -1.0), 0.05, 1.0, Outcome.NOT_RIGID),  # a mirror image
        (changed(3, 0, 0.5), 0.05, 1.0, Outcome.NOT_RIGID),
        (np.zeros((4, 4)), 0.05, 1.0, Outcome.NOT_RIGID),
        (raised(), PANDA.opening + 0.001, 1.0, Outcome.TOO_WIDE),
        (raised(), -0.001, 1.0, Outcome.TOO_WIDE),
        (raised(finger_span(PANDA)[1] - 0.001), 0.05, 1.0, Outcome.BELOW_TABLE),
    ],
)
def test_what_the_hand_cannot_do_has_a_name(pose, width, score, outcome):
    assert Grasp.of_pose(pose, width, score).infeasibility(PANDA) == outcome


def test_the_best_grasp_that_can_be_done_is_tried():
    poses = np.stack([raised(), raised(0.2), raised(-1), raised(0.3)])
    grasps = GraspPoses(poses, np.array([1.0, 0.05, 0.05, 0.05]), np.array([4.0, 2, 3, 2]))
    best = choose(grasps, PANDA)
    assert isinstance(best, Grasp)
    assert (best.pose[2, 3], best.quality) == (0.2, 2.0)


def test_without_any_the_flaw_of_the_most_promising_is_told():
    poses = np.stack([raised(-1), raised(), raised()])
    grasps = GraspPoses(poses, np.array([0.05, 1.0, 0.05]), np.array([1.0, 2.0, np.nan]))
    assert choose(grasps, PANDA) == Outcome.TOO_WIDE
    assert choose(poses_of(([], [], [])), PANDA) == Outcome.NO_GRASP


def test_the_best_come_first():
    grasps = GraspPoses(
        np.stack([raised(n) for n in range(5)]), np.arange(5.0), np.array([1, 5, 2, 5, 0.0])
    )
    np.testing.assert_array_equal(best_poses(grasps, 3).widths, [1, 3, 2])


def test_a_grasp_from_above_is_a_pose_with_the_same_fingertips():
    grasp = Grasp((0.1, 0.2, 0.05), 0.7, 0.04, 0.02, 0.9)
    posed = grasp.as_pose(PANDA)
    pose = posed.pose
    np.testing.assert_allclose(pose[:3, :3].T @ pose[:3, :3], np.eye(3), atol=1e-12)
    np.testing.assert_allclose(pose[:3, 0], [np.cos(0.7), np.sin(0.7), 0])
    np.testing.assert_allclose(pose[:3, 2], [0, 0, -1])
    tip = pose[:3, 3] + finger_span(PANDA)[1] * pose[:3, 2]
    np.testing.assert_allclose(tip, [0.1, 0.2, grasp.tip])
    assert (posed.width, posed.quality) == (0.04, 0.9)
    assert posed.infeasibility(PANDA) is None
    back = posed.from_above(PANDA)
    assert (back.tip, back.angle) == pytest.approx((grasp.tip, grasp.angle))

"""The reference learns which grasps of an object hold, wherever the object lies."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from egad.bench.failures.reference import ReferencePolicy
from egad.detectors import Grasp
from egad.sim import Pose

DOWN = np.diag([1.0, -1.0, -1.0, 1.0])
MOVED = Pose(np.array([0.3, -0.1, 0.02]), Rotation.from_euler("z", 70, degrees=True).as_quat())
HERE = Pose(np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0]))


def at(x, width=0.05):
    pose = DOWN.copy()
    pose[0, 3] = x
    return Grasp.of_pose(pose, width, 1.0)


class FakeRunner:
    """Labelled grasps at places along the object's x axis, best first."""

    def __init__(self, *places):
        self.places = places

    def labelled(self, rest):
        return [each.moved(rest.matrix) for each in map(at, self.places)]

    def can_do(self, grasp):
        return grasp.pose[2, 2] < -0.9


def first_place(policy, runner, rest=HERE):
    found = policy.ranked(runner, rest)[0]
    return float((np.linalg.inv(rest.matrix) @ found.pose)[0, 3])


def test_without_trials_the_order_of_the_labels_stays():
    found = ReferencePolicy().ranked(FakeRunner(0.0, 0.05, 0.1), HERE)
    assert [each.pose[0, 3] for each in found] == [0.0, 0.05, 0.1]
    assert ReferencePolicy().ranked(FakeRunner(), HERE) == []


@pytest.mark.parametrize("rest", [HERE, MOVED])
def test_what_failed_is_not_tried_again_nor_what_is_beside_it(rest):
    policy, runner = ReferencePolicy(), FakeRunner(0.0, 0.002, 0.05)
    policy.remember(rest, runner.labelled(rest)[0], success=False)
    assert first_place(policy, runner) == pytest.approx(0.05)
    assert first_place(policy, runner, MOVED) == pytest.approx(0.05)


def test_a_grasp_that_held_is_used_wherever_the_object_lies():
    policy, runner = ReferencePolicy(), FakeRunner(0.0)
    for _ in range(3):
        policy.remember(HERE, at(0.2), success=True)
        policy.remember(HERE, at(0.0), success=False)
    assert first_place(policy, runner) == pytest.approx(0.2)
    assert first_place(policy, runner, MOVED) == pytest.approx(0.2)


def test_a_grasp_that_the_hand_cannot_come_to_now_is_left_out():
    policy = ReferencePolicy()
    policy.remember(HERE, at(0.2), success=True)
    over = Pose(np.zeros(3), Rotation.from_euler("x", 90, degrees=True).as_quat())
    assert policy.ranked(FakeRunner(), over) == []


def test_grasps_from_other_sides_are_not_alike():
    policy, runner = ReferencePolicy(), FakeRunner(0.0)
    turned = at(0.0)
    turned.pose[:3, :3] = Rotation.from_euler("y", 40, degrees=True).as_matrix() @ DOWN[:3, :3]
    for _ in range(5):
        policy.remember(HERE, turned, success=False)
    policy.remember(HERE, at(0.3), success=True)
    assert first_place(policy, runner) == 0.0  # 0.9 for the label, 0.75 for the other one

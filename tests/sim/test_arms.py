"""Arms: their kinematics are those of the engines, and the hand comes to where it is wanted."""

import numpy as np
import pytest
import trimesh
from worlds import EACH_ARM, EACH_ENGINE, HAND, start

from egad.geometry import Bundle
from egad.sim.arms import ARMS, PANDA_READY, HandPose, Panda, UnreachableError
from egad.sim.model import build
from egad.sim.parameters import EngineName
from egad.sim.robot import TIP

BALL = build(trimesh.creation.icosphere(2, 0.02), 400.0, Bundle())


def tip_in(world):
    """Where the engine sees the tip of the robot, (4, 4)."""
    names = [link.name for link in world.robot.links]
    return world.link_poses()[names.index(TIP)].matrix


@EACH_ENGINE
@EACH_ARM
def test_both_engines_see_the_tip_where_the_arm_says(engine: EngineName, arm: str) -> None:
    rng = np.random.default_rng(0)
    limits = {"axis": [(0.0, 0.5), (-3.0, 3.0)], "panda": Panda(HAND)._limits}[arm]
    with start(engine, BALL, arm=arm) as world:
        for _ in range(3):
            joints = rng.uniform(*np.transpose(limits))
            mount = ARMS[arm](HAND)
            base = mount.base(HandPose(0.1, 0.2, 0.0, 0.0))
            world.reset()
            world.put_robot(base, joints.tolist(), 0.05)
            expected = base.matrix @ mount.robot.tip_poses(joints.tolist())[-1]
            np.testing.assert_allclose(tip_in(world), expected, atol=1e-6)
            np.testing.assert_allclose(world.arm_joints(), joints, atol=1e-9)


@EACH_ARM
@pytest.mark.parametrize("angle", [-2.0, 0.0, 0.7, 3.0])
def test_the_hand_points_down_where_it_is_wanted(arm: str, angle: float) -> None:
    """The closing axis is x of the tip; a hand is its own mirror image."""
    mount, hand_pose = ARMS[arm](HAND), HandPose(0.05, -0.08, 0.12, angle)
    joints = mount.joints(hand_pose)
    tip = mount.base(hand_pose).matrix @ mount.robot.tip_poses(joints.tolist())[-1]
    np.testing.assert_allclose(tip[:3, 3], hand_pose[:3], atol=1e-5)
    np.testing.assert_allclose(tip[:3, 2], (0, 0, -1), atol=1e-5)
    assert abs(tip[:2, 0] @ (np.cos(angle), np.sin(angle))) == pytest.approx(1, abs=1e-6)
    assert mount.height(joints) == pytest.approx(hand_pose.height, abs=1e-5)


def test_a_panda_follows_a_path_and_knows_its_reach() -> None:
    panda = Panda(HAND)
    joints = panda.joints(HandPose(0.0, 0.1, 0.05, 0.4))
    for height in np.linspace(0.05, 0.45, 200):
        joints = panda.joints(HandPose(0.0, 0.1, float(height), 0.4), joints)
    assert panda.height(joints) == pytest.approx(0.45, abs=0.001)
    with pytest.raises(UnreachableError):
        panda.joints(HandPose(0.0, 0.0, 1.5, 0.0))


def test_ready_is_where_franka_says() -> None:
    """The flange of a Panda that is ready is 0.307 m in front of its base and 0.59 m high."""
    panda = Panda(HAND)
    flange = panda.robot.tip_poses(list(PANDA_READY))[-1][:3, 3].copy()
    flange[2] += HAND.palm[2] + HAND.finger_length
    np.testing.assert_allclose(flange, (0.307, 0.0, 0.59), atol=0.001)

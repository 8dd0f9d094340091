"""A hand without an arm grasps from any direction, and is stopped by what is in its way."""

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation
from standing_cube import CUBE, DOWN, SIDE, UPRIGHT, grasp, stand
from worlds import EACH_ENGINE, HAND

from egad.geometry import Bundle
from egad.grippers import finger_span
from egad.sim.engines import open_world
from egad.sim.execution import RETREAT, STANDOFF, ContactRules, execute_pose
from egad.sim.jaws import FreeHand
from egad.sim.model import build
from egad.sim.parameters import EngineName
from egad.sim.robots import free_hand
from egad.sim.world import Pose
from egad.tables.outcomes import Outcome

TALL = build(trimesh.creation.box((SIDE, SIDE, 0.2)), 500.0, Bundle())


@EACH_ENGINE
@pytest.mark.parametrize("turn", [0.0, 0.7])
def test_a_hand_moves_to_where_it_is_told(engine: EngineName, turn: float) -> None:
    """The fingertips are where the pose says, before and after a straight motion."""
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_euler("xyz", [np.pi - 0.4, 0.3, turn]).as_matrix()
    pose[:3, 3] = [0.05, -0.03, 0.3]
    shift = np.array([0.02, 0.03, 0.04])
    with open_world(engine, [CUBE], free_hand(HAND)) as world:
        world.place(Pose(np.array([1.0, 0, SIDE / 2]), UPRIGHT))
        hand = FreeHand(world, pose, 0.05)
        assert world.robot is not None
        tip = [link.name for link in world.robot.links].index("tip")
        reach = finger_span(HAND)[1] * pose[:3, 2]
        for moved in (np.zeros(3), shift):
            if moved.any():
                assert hand.move(moved, 0.2, 20.0) == 0
                world.step(48)
            found = world.link_poses()[tip]
            np.testing.assert_allclose(found.position, pose[:3, 3] + reach + moved, atol=0.001)
            np.testing.assert_allclose(found.matrix[:3, :3], pose[:3, :3], atol=0.002)
        assert hand.opening() == pytest.approx(0.05, abs=0.001)


@EACH_ENGINE
@pytest.mark.parametrize(
    ("axis", "approach"),
    [
        pytest.param([1, 0, 0], DOWN, id="from above"),
        pytest.param([0, 1, 0], [0.6, 0, -0.8], id="slanted"),
        pytest.param([0, 1, 0], [1, 0, 0], id="from the side"),
    ],
)
def test_an_object_is_held_from_any_side(
    engine: EngineName, axis: list[float], approach: list[float]
) -> None:
    with open_world(engine, [TALL], free_hand(HAND)) as world:
        stand(world, 0.2)
        before = world.pose().position
        result = execute_pose(world, grasp([0, 0, 0.17], axis, approach), HAND.opening)
        assert (result.outcome, result.held, result.stopped) == (Outcome.SUCCESS, 0, 0.0)
        way = -np.array(approach, float) if approach[2] < -0.5 else np.array([0, 0, 1.0])
        moved = world.pose().position - before
        np.testing.assert_allclose(moved, RETREAT * way, atol=0.01)


@EACH_ENGINE
@pytest.mark.parametrize("contact", ["close", "collided"])
def test_a_hand_that_the_table_stops_closes_only_if_it_may(
    engine: EngineName, contact: str
) -> None:
    with open_world(engine, [CUBE], free_hand(HAND)) as world:
        stand(world, SIDE)
        result = execute_pose(world, grasp([0, 0, 0], [1, 0, 0], DOWN), 0.07, ContactRules(contact))
        assert result.stopped > 0.005
        assert result.outcome == (Outcome.SUCCESS if contact == "close" else Outcome.COLLIDED)


@EACH_ENGINE
def test_a_hand_that_begins_within_an_object_collides(engine: EngineName) -> None:
    with open_world(engine, [TALL], free_hand(HAND)) as world:
        stand(world, 0.2)
        result = execute_pose(world, grasp([0.03, 0, 0.05], [1, 0, 0], DOWN), 0.07)
        assert (result.outcome, result.stopped) == (Outcome.COLLIDED, STANDOFF)


@EACH_ENGINE
def test_a_hand_that_was_stopped_does_not_push_on(engine: EngineName) -> None:
    """The palm is stopped by a tall block; while the fingers close, it stays where it is."""
    with open_world(engine, [TALL], free_hand(HAND)) as world:
        stand(world, 0.2)
        begin = grasp([0, 0, 0.22], [1, 0, 0], DOWN)
        hand = FreeHand(world, begin, HAND.opening)
        stopped = hand.move(np.array([0, 0, -0.15]), 0.25, 20.0)
        assert 0.05 < stopped < 0.15
        before = world.arm_joints().copy()
        hand.close()
        np.testing.assert_allclose(world.arm_joints(), before, atol=0.002)
        assert world.forces().hand - world.forces().left - world.forces().right < 60


def test_what_was_stopped_early_may_still_succeed() -> None:
    """The palm is stopped by the top of a tall block, and the fingers hold it all the same."""
    with open_world("mujoco", [TALL], free_hand(HAND)) as world:
        stand(world, 0.2)
        result = execute_pose(world, grasp([0, 0, 0.15], [1, 0, 0], DOWN), HAND.opening)
        assert result.stopped > 0
        assert result.outcome == Outcome.SUCCESS

"""Hands of makers' files in both engines: fingers on sliding joints, and a linkage."""

import numpy as np
import pytest
import trimesh
from described_hands import box_urdf, linkage_mjcf

from egad.geometry import Bundle
from egad.grippers import Gripper, model_of
from egad.sim.arms import ARMS, HandPose
from egad.sim.engines import open_world
from egad.sim.execution import execute_pose
from egad.sim.jaws import Hand
from egad.sim.model import build
from egad.sim.parameters import is_installed
from egad.sim.robots import free_hand, on_axis
from egad.sim.urdf import to_urdf
from egad.sim.world import Pose

SIDE, TIP = 0.04, 0.012
BLOCK = build(trimesh.creation.box((SIDE,) * 3), 1000.0, Bundle())
UPRIGHT = np.array([0.0, 0.0, 0.0, 1.0])
WRITERS = {"boxes": box_urdf, "linkage": linkage_mjcf}
LOOSE = {"mujoco": 5e-4, "pybullet": 2e-3, "drake": 2e-3}  # metres that a linkage yields under 40 N


@pytest.fixture(scope="module", params=WRITERS)
def gripper(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("hand")
    return Gripper.from_file(WRITERS[request.param](folder / "hand.xml"), force=40)


@pytest.fixture(params=LOOSE)
def engine(request):
    if not is_installed(request.param):
        pytest.skip("not installed")
    return request.param


def closed_on_the_block(world, arm):
    """A hand that has closed on the block on the table, its fingertips 12 mm above the table."""
    world.place(Pose(np.array([0.0, 0.0, SIDE / 2]), UPRIGHT))
    hand = Hand(world, arm, HandPose(0, 0, 0.15, 0), arm.robot.gripper.opening, SIDE)
    assert hand.move(TIP, 0.6) is None
    assert hand.close()
    return hand


@pytest.mark.parametrize("arm", ARMS)
def test_a_block_is_held_with_the_force_of_the_gripper_and_lifted(gripper, engine, arm):
    carrier = ARMS[arm](gripper)
    with open_world(engine, [BLOCK], carrier.robot) as world:
        hand = closed_on_the_block(world, carrier)
        assert hand.opening() == pytest.approx(SIDE, abs=2 * LOOSE[engine])
        forces = world.forces()
        assert [forces.left, forces.right] == pytest.approx([40, 40], rel=0.4)
        assert hand.lift(0.1, 0.5)
        assert hand.carries()
        assert world.pose().position[2] == pytest.approx(0.1 + SIDE / 2, abs=5e-3)


def test_links_are_where_the_model_has_them(gripper, engine):
    """Of the hand that has closed, seen from its palm."""
    carrier, model = ARMS["axis"](gripper), model_of(gripper)
    robot = carrier.robot
    with open_world(engine, [BLOCK], robot) as world:
        hand = closed_on_the_block(world, carrier)
        poses = dict(zip((link.name for link in robot.links), world.link_poses(), strict=True))
        opening = hand.opening()
    back = np.linalg.inv(poses["palm"].matrix)
    turns, places = model.poses(opening)
    shift = None
    for number, link in enumerate(model.links):
        if f"hand-{link.name}" not in poses:
            continue
        seen = back @ poses[f"hand-{link.name}"].matrix
        anchor = np.zeros(3) if link.joint is None else link.joint.anchor
        expected = turns[number] @ anchor + places[number]
        shift = seen[:3, 3] - expected if shift is None else shift
        np.testing.assert_allclose(seen[:3, 3] - expected, shift, atol=LOOSE[engine])
        np.testing.assert_allclose(seen[:3, :3], turns[number], atol=20 * LOOSE[engine])
    assert shift is not None
    np.testing.assert_allclose(shift[:2], 0, atol=LOOSE[engine])


def test_fingertips_are_where_they_are_wanted_when_they_meet_the_object(gripper, engine):
    """Those of the engine's own links, although they reach deeper when the linkage is open."""
    carrier = ARMS["axis"](gripper)
    with open_world(engine, [BLOCK], carrier.robot) as world:
        closed_on_the_block(world, carrier)
        poses = world.link_poses()
    lowest = min(
        float((shape.points @ pose.matrix[:3, :3].T + pose.position)[:, 2].min())
        for link, pose in zip(carrier.robot.links, poses, strict=True)
        for shape in link.shapes
        if link.name in carrier.robot.sides
    )
    assert lowest == pytest.approx(TIP, abs=LOOSE[engine])


def test_a_free_hand_grasps_where_its_pads_are(gripper, engine):
    """From above: the pads of the open hand are at the pose when it has come there."""
    robot = free_hand(gripper)
    down = np.diag([1.0, -1.0, -1.0, 1.0])
    down[2, 3] = 0.035
    with open_world(engine, [BLOCK], robot) as world:
        world.place(Pose(np.array([0.0, 0.0, SIDE / 2]), UPRIGHT))
        world.step(30)
        found = execute_pose(world, down, gripper.opening)
    assert found.outcome == "success"
    assert found.held == 0


def test_urdf_has_no_long_lines(gripper):
    """PyBullet cuts them."""
    assert max(map(len, to_urdf(on_axis(gripper)).splitlines())) < 8192

"""A hand with one moving jaw in all engines: driven by torque, one-sided, at an angle."""

import numpy as np
import pytest
import trimesh
from described_hands import jaw_urdf
from scipy.spatial.transform import Rotation

from egad.detectors import Grasp
from egad.geometry import Bundle
from egad.grasps import FIXED_SIDE_CLEARANCE
from egad.grippers import JAW_CLEARANCE, Gripper, finger_span, model_of
from egad.sim.arms import ARMS, HandPose
from egad.sim.engines import open_world
from egad.sim.execution import execute_pose, place_hand_above
from egad.sim.jaws import Hand
from egad.sim.model import build
from egad.sim.parameters import ENGINES, is_installed
from egad.sim.robots import free_hand, on_axis
from egad.sim.world import WEIGHTLESS, Pose

SIDE, FORCE = 0.03, 10.0
UPRIGHT = np.array([0.0, 0.0, 0.0, 1.0])
BLOCK = build(trimesh.creation.box((SIDE, SIDE, 0.02)), 1000.0, Bundle())
ROUND = Bundle(deviation=1e-5, max_vertices=1000)
TIP = 0.004


@pytest.fixture(scope="module", params=[False, True], ids=["swings", "slides"])
def any_hand(request, tmp_path_factory):
    path = tmp_path_factory.mktemp("hand") / "jaw.urdf"
    return Gripper.from_file(jaw_urdf(path, slides=request.param), force=FORCE)


@pytest.fixture(scope="module")
def swinging(tmp_path_factory):
    return Gripper.from_file(jaw_urdf(tmp_path_factory.mktemp("hand") / "jaw.urdf"), force=FORCE)


@pytest.fixture(params=ENGINES)
def engine(request):
    if not is_installed(request.param):
        pytest.skip("not installed")
    return request.param


def above(world, gripper, arm="axis", contact=SIDE, angle=0.0, width=None):
    """The open hand around the block on the table, its fingertips 4 mm above the table."""
    world.place(Pose(np.array([0.0, 0.0, 0.01]), Rotation.from_euler("z", angle).as_quat()))
    opening = gripper.opening if width is None else width
    hand = Hand(world, ARMS[arm](gripper), HandPose(0, 0, 0.12, angle), opening, contact)
    assert hand.move(TIP, 0.6) is None
    return hand


@pytest.mark.parametrize("arm", ARMS)
def test_a_block_is_held_with_the_force_of_the_gripper_and_lifted(any_hand, engine, arm):
    with open_world(engine, [BLOCK], ARMS[arm](any_hand).robot) as world:
        hand = above(world, any_hand, arm)
        assert hand.close()
        forces = world.forces()
        # torque over the depth of the contact below the hinge: the block reaches up the jaw
        assert [forces.left, forces.right] == pytest.approx([FORCE, FORCE], rel=0.35)
        assert hand.lift(0.1, 0.6)
        assert hand.carries()
        assert world.pose().position[2] == pytest.approx(0.11, abs=5e-3)


def test_a_block_against_the_fixed_jaw_stays_where_it_is(any_hand, engine):
    """It is pushed by the clearance of the fixed jaw, and not by half of what the hand opens."""
    with open_world(engine, [BLOCK], on_axis(any_hand)) as world:
        hand = above(world, any_hand)
        assert hand.close()
        shift = world.pose().position - [0, 0, 0.01]
        assert shift[0] == pytest.approx(-JAW_CLEARANCE, abs=7e-4)
        assert np.abs(shift[1:]).max() < 1e-3


@pytest.mark.parametrize(("width", "pushed"), [(SIDE + 0.016, FIXED_SIDE_CLEARANCE), (1.0, None)])
def test_a_grasp_from_an_image_tells_where_the_object_is_by_its_opening(
    swinging, engine, width, pushed
):
    """It is 8 mm wider than the object on either side; a hand that is wide open is centered."""
    width = min(width, swinging.opening)
    arm = ARMS["axis"](swinging)
    with open_world(engine, [BLOCK], arm.robot) as world:
        world.place(Pose(np.array([0.0, 0.0, 0.01]), UPRIGHT))
        grasp = Grasp((0.0, 0.0, 0.01), 0.0, width, 0.006, quality=1.0)
        hand = place_hand_above(world, arm, grasp, 0.12)
        assert hand.move(TIP, 0.6) is None
        assert hand.close()
        expected = (width - SIDE) / 2 if pushed is None else pushed
        assert world.pose().position[0] == pytest.approx(-expected, abs=1.5e-3)


@pytest.mark.parametrize("angle", [0.7, 2.5, -2.0])
def test_the_fixed_jaw_is_at_the_lower_end_of_the_closing_axis(swinging, engine, angle):
    with open_world(engine, [BLOCK], on_axis(swinging)) as world:
        above(world, swinging, angle=angle)
        axis = np.array([np.cos(angle), np.sin(angle), 0])
        ends = {}
        for link, pose in zip(world.robot.links, world.link_poses(), strict=True):
            points = [shape.points for shape in link.shapes if link.name in world.robot.sides]
            if points:
                places = np.concatenate(points) @ pose.matrix[:3, :3].T + pose.position
                ends[world.robot.sides[link.name]] = places @ axis
        assert ends["right"].max() == pytest.approx(-SIDE / 2 - JAW_CLEARANCE, abs=5e-4)
        assert ends["left"].min() > SIDE / 2


def test_the_joint_never_has_more_than_its_torque(swinging):
    with open_world("mujoco", [BLOCK], on_axis(swinging)) as world:
        hand = above(world, swinging)
        assert hand.close()
        torque = world.data.actuator_force[-2:]  # hold, and close
        most = FORCE * model_of(swinging).lever
        assert np.abs(torque).max() == pytest.approx(most, rel=0.02)
        assert np.abs(torque).max() <= most * (1 + 1e-9)


@pytest.mark.parametrize(("diameter", "nearer"), [(0.0158, 0.0), (0.0252, 0.045)])
def test_a_ball_is_pressed_by_the_torque_over_its_distance_from_the_hinge(
    swinging, engine, diameter, nearer
):
    """Both balls stop the jaw where its faces are parallel to the fixed ones: at 0 degrees."""
    torque = 0.6
    gripper = Gripper.from_file(swinging.file, torque=torque, friction=0.3)
    ball = build(trimesh.creation.icosphere(4, diameter / 2), 300.0, ROUND)
    with open_world(engine, [ball], on_axis(gripper)) as world:
        world.place(Pose(np.array([0.0, 0.0, 0.1 + nearer]), UPRIGHT))
        world.set_gravity(WEIGHTLESS)
        hand_pose = HandPose(0, 0, 0.1 - finger_span(gripper)[1], 0.0)
        hand = Hand(world, ARMS["axis"](gripper), hand_pose, gripper.opening, 0.0158)
        hand.close()
        world.step(60)
        forces = world.forces()
    expected = torque / (model_of(gripper).lever - nearer)
    assert [forces.left, forces.right] == pytest.approx([expected, expected], rel=0.04)


@pytest.fixture(scope="module")
def balls():
    return {
        diameter: build(trimesh.creation.icosphere(4, diameter / 2), 300.0, ROUND)
        for diameter in (0.024, 0.045)
    }


@pytest.mark.parametrize(
    ("diameter", "friction", "held"),
    [(0.024, 0.1, True), (0.045, 0.05, False), (0.045, 0.3, True)],
)
def test_balls_are_squeezed_out_where_half_the_angle_exceeds_friction(
    swinging, balls, engine, diameter, friction, held
):
    """At 24 mm the jaws are at 6 degrees, at 45 mm at 22.

    Friction of 0.1 holds up to 11 degrees, 0.05 up to 6. At 0.1 and 22 degrees the edges of a mesh
    catch in PyBullet, in 1 of 9 positions that differ by 25 micrometres.
    """
    gripper = swinging.model_copy(update={"friction": friction})
    with open_world(engine, [balls[diameter]], on_axis(gripper)) as world:
        height = 0.1
        world.place(Pose(np.array([0.0, 0.0, height]), UPRIGHT))
        world.set_gravity(WEIGHTLESS)
        hand_pose = HandPose(0, 0, height - finger_span(gripper)[1], 0.0)
        hand = Hand(world, ARMS["axis"](gripper), hand_pose, gripper.opening, diameter)
        hand.close()
        world.step(120)
        assert hand.pinches() == held


def test_a_free_hand_grasps_where_its_open_pads_are(swinging, engine):
    """From above, its fixed jaw 1 mm before the block."""
    opening = swinging.opening
    down = np.diag([1.0, -1.0, -1.0, 1.0])
    down[:3, 3] = (opening - SIDE) / 2 - JAW_CLEARANCE, 0, TIP + finger_span(swinging)[1]
    with open_world(engine, [BLOCK], free_hand(swinging)) as world:
        world.place(Pose(np.array([0.0, 0.0, 0.01]), UPRIGHT))
        world.step(30)
        found = execute_pose(world, down, opening)
    assert found.outcome == "success"
    assert found.held == 0

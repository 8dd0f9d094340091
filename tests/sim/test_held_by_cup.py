"""A suction cup holds what its limits allow in both engines, with closed forms as the reference."""

from collections.abc import Sequence

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation
from worlds import EACH_ARM, EACH_ENGINE

import egad
from egad.bench import TrialProtocol
from egad.detectors import Grasp
from egad.geometry import Bundle
from egad.grippers import Gripper
from egad.sim.arms import ARMS
from egad.sim.engines import open_world
from egad.sim.execution import LIFT_SPEED, RETREAT, RETREAT_SPEED, Execution, execute, execute_pose
from egad.sim.model import Model, build
from egad.sim.parameters import EngineName
from egad.sim.robots import free_hand
from egad.sim.world import GRAVITY, TIME_STEP, Pose, World
from egad.tables.outcomes import Outcome

SIDES = (0.06, 0.06, 0.04)
DENSITY = 1000.0
CUP = egad.SuctionCup(radius=0.015)
STRONG = {"torque_tolerance": 100.0}  # so that only forces can be too large
RING = np.array([0.0, 0.0, 0.5])
DOWN = Rotation.from_euler("x", np.pi)  # of a cup that comes from above


def box(mass: float = 0.144, sides: Sequence[float] = SIDES) -> Model:
    return build(trimesh.creation.box(sides), mass / float(np.prod(sides)), Bundle())


def with_cup(**settings: float) -> Gripper:
    return Gripper(cup=egad.SuctionCup(radius=0.015, **settings))


def own_axes(model: Model) -> Rotation:
    """From the principal frame of an object to that of its mesh."""
    return Rotation.from_matrix(model.to_principal[:3, :3].T)


def hang(world: World, turn: Rotation, offset: Sequence[float]) -> None:
    """Attach the object with its center of mass at an offset from the ring, in the cup's frame."""
    model = world.model
    place = Pose(RING + turn.apply(offset), (turn * own_axes(model)).as_quat())
    world.place(place)
    world.put_robot(Pose(RING, turn.as_quat()), [0.0, 0.0, 0.0], 0.0)
    world.attach(0)


def holds(engine: EngineName, gripper: Gripper, mass: float, turn: Rotation, lever: float) -> bool:
    """Whether a cup still holds an object at rest after a second."""
    with open_world(engine, [box(mass)], free_hand(gripper)) as world:
        hang(world, turn, [lever, 0.0, 0.02])
        world.step(240)
        assert (world.attached == 0) == (world.pose().position[2] > 0.4)
        return world.attached == 0


@EACH_ENGINE
@pytest.mark.parametrize("angles", [(0.0, 0.0, 0.0), (0.5, -0.3, 0.4), (np.pi / 2, 0.0, 0.2)])
def test_the_load_at_rest_is_the_weight_at_its_lever(
    engine: EngineName, angles: tuple[float, float, float]
) -> None:
    turn, offset = DOWN * Rotation.from_euler("xyz", angles), np.array([0.005, -0.003, 0.02])
    with open_world(engine, [box()], free_hand(with_cup(**STRONG))) as world:
        hang(world, turn, offset)
        world.step(240)
        weight = turn.inv().apply([0.0, 0.0, -0.144 * GRAVITY])
        expected = np.concatenate([weight, np.cross(offset, weight)])
        np.testing.assert_allclose(world.load(), expected, atol=2e-3 * 0.144 * GRAVITY)
        world.detach()
        assert world.attached is None
        np.testing.assert_array_equal(world.load(), np.zeros(6))


@EACH_ENGINE
def test_the_load_of_a_lift_is_that_of_its_acceleration(engine: EngineName) -> None:
    """Along z m (g + a), with a from the heights of the object; a at most 5.77 h / T^2."""
    gripper, heights, loads = with_cup(), [], []
    with open_world(engine, [box()], ARMS["axis"](gripper).robot) as world:
        stand(world)

        def note(world: World) -> None:
            if world.attached is not None:
                heights.append(world.pose().position[2])
                loads.append(world.load())

        world.watch = note
        assert lift(world, gripper).outcome == Outcome.SUCCESS
    found, acceleration = np.array(loads), np.diff(heights, 2) / TIME_STEP**2
    expected = 0.144 * (GRAVITY + acceleration)
    hanging = slice(20, None)
    np.testing.assert_allclose(found[1:-1, 2][hanging], expected[hanging], atol=0.04)
    np.testing.assert_allclose(found[20:, [0, 1, 3, 4, 5]], 0.0, atol=2e-3)
    assert found[20:, 2].max() == pytest.approx(0.144 * (GRAVITY + steepest()), rel=0.01)


def steepest() -> float:
    """The greatest acceleration of the lift of a trial, m/s2: of a minimum-jerk path."""
    height = TrialProtocol().lift_height
    return 10 / np.sqrt(3) * height / (height / LIFT_SPEED) ** 2


@EACH_ENGINE
@pytest.mark.parametrize(("share", "kept"), [(0.98, True), (1.02, False)])
def test_a_weight_above_the_vacuum_force_falls(
    engine: EngineName, share: float, kept: bool
) -> None:
    gripper = with_cup(vacuum_force=10.0)
    assert holds(engine, gripper, share * 10.0 / GRAVITY, DOWN, 0.0) == kept


@EACH_ENGINE
@pytest.mark.parametrize(("share", "kept"), [(0.97, True), (1.03, False)])
def test_a_lever_beyond_the_bending_limit_falls(
    engine: EngineName, share: float, kept: bool
) -> None:
    """It turns about y of the cup alone: pi r kappa / sqrt(2), and what is tolerated."""
    limit = np.pi * CUP.radius * CUP.bending / np.sqrt(2) + CUP.torque_tolerance
    lever = share * limit / (0.3 * GRAVITY)
    assert 0.005 < lever < 0.015
    assert holds(engine, with_cup(), 0.3, DOWN, lever) == kept


@EACH_ENGINE
@pytest.mark.parametrize("factor", [1.0, 0.5])
@pytest.mark.parametrize(("share", "kept"), [(0.98, True), (1.02, False)])
def test_a_weight_above_the_friction_of_a_level_cup_falls(
    engine: EngineName, factor: float, share: float, kept: bool
) -> None:
    """It pulls along x of the cup: mu V / sqrt(3); the friction may be off."""
    gripper = with_cup(vacuum_force=10.0, **STRONG)
    level = Rotation.from_matrix(np.array([[0.0, 0, -1], [0, 1, 0], [1, 0, 0]]).T)
    np.testing.assert_allclose(level.apply([1.0, 0, 0]), [0, 0, -1], atol=1e-12)
    mass = share * factor * CUP.friction * 10.0 / np.sqrt(3) / GRAVITY
    with open_world(engine, [box(mass)], free_hand(gripper)) as world:
        world.friction_factor = factor
        world.reset()
        hang(world, level, [0.0, 0.0, 0.02])
        world.step(240)
        assert (world.attached == 0) == kept


def stand(world: World, height: float = SIDES[2]) -> None:
    world.reset()
    world.place(Pose(np.array([0.0, 0.0, height / 2]), own_axes(world.model).as_quat()))
    world.step(24)


def lift(
    world: World, gripper: Gripper, x: float = 0.0, z: float = SIDES[2], arm: str = "axis"
) -> Execution:
    grasp = Grasp((x, 0.0, z), 0.0, 0.0, 0.01, 1.0)
    return execute(world, ARMS[arm](gripper), TrialProtocol(), grasp)


@EACH_ENGINE
@EACH_ARM
def test_a_box_is_lifted_where_the_cup_seals(engine: EngineName, arm: str) -> None:
    """The ring must lie on the face, and the cup looks for it 10 mm beyond its place."""
    gripper = with_cup()
    cases = {
        (0.0, 0.04): Outcome.SUCCESS,
        (0.01, 0.04): Outcome.SUCCESS,
        (0.0, 0.034): Outcome.SUCCESS,
        (0.0, 0.048): Outcome.SUCCESS,
        (0.0, 0.054): Outcome.NO_SEAL,
        (0.017, 0.04): Outcome.NO_SEAL,
        (0.2, 0.04): Outcome.NO_SEAL,
    }
    with open_world(engine, [box()], ARMS[arm](gripper).robot) as world:
        for (x, z), expected in cases.items():
            stand(world)
            found = lift(world, gripper, x, z, arm)
            assert (found.outcome, found.stopped) == (expected, 0.0)
            lifted = TrialProtocol().lift_height if expected == Outcome.SUCCESS else 0.0
            assert found.lifted == pytest.approx(lifted, abs=0.005)


@EACH_ENGINE
@pytest.mark.parametrize(
    ("share", "outcome"), [(0.97, Outcome.SUCCESS), (1.03, Outcome.SLIPPED_LIFTING)]
)
def test_what_can_be_held_but_not_speeded_up_is_lost_in_the_lift(
    engine: EngineName, share: float, outcome: Outcome
) -> None:
    gripper = with_cup(vacuum_force=10.0)
    mass = share * 10.0 / (GRAVITY + steepest())
    with open_world(engine, [box(mass)], ARMS["axis"](gripper).robot) as world:
        stand(world)
        assert lift(world, gripper).outcome == outcome


@EACH_ENGINE
def test_a_stem_that_meets_a_pin_inside_the_ring_collides(engine: EngineName) -> None:
    """The pin is thinner than the ring and longer than the cup is high."""
    plate = trimesh.creation.box((0.08, 0.08, 0.02)).apply_translation([0, 0, -0.01])
    pin = trimesh.creation.cylinder(0.003, 0.1, sections=24)
    mesh = trimesh.boolean.union([plate, pin], engine="manifold")
    model, gripper = build(mesh, DENSITY, Bundle()), with_cup()
    with open_world(engine, [model], ARMS["axis"](gripper).robot) as world:
        turn = own_axes(model)
        com = -turn.apply(model.to_principal[:3, 3])
        world.place(Pose(np.array([0.0, 0.0, 0.05]) + com, turn.as_quat()))
        world.step(48)
        found = lift(world, gripper, 0.0, 0.05)
    assert found.outcome == Outcome.COLLIDED
    assert found.stopped > 0.01


@EACH_ENGINE
@pytest.mark.parametrize("share", [0.95, 1.05])
def test_a_free_cup_holds_from_the_side_and_tells_which_object(
    engine: EngineName, share: float
) -> None:
    """The lever is 20 mm, and it moves up by the fastest minimum-jerk path over 0.1 m."""
    limit = np.pi * CUP.radius * CUP.bending / np.sqrt(2) + CUP.torque_tolerance
    rise = 10 / np.sqrt(3) * RETREAT / (RETREAT / RETREAT_SPEED) ** 2
    tall = box(share * limit / 0.02 / (GRAVITY + rise), (0.04, 0.04, 0.12))
    turn = own_axes(tall).as_quat()
    pose = np.eye(4)
    pose[:3, :3] = np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]]).T  # comes along x
    pose[:3, 3] = [-0.02, 0.0, 0.07]
    with open_world(engine, [tall, tall], free_hand(with_cup())) as world:
        for number, x in ((0, 0.1), (1, 0.0)):
            world.place(Pose(np.array([x, 0.0, 0.06]), turn), number=number)
        world.step(24)
        before = world.pose(1).position
        found = execute_pose(world, pose, 0.0)
        if share > 1:
            assert (found.outcome, found.held) == (Outcome.SLIPPED_LIFTING, None)
            return
        assert (found.outcome, found.held, found.stopped) == (Outcome.SUCCESS, 1, 0.0)
        np.testing.assert_allclose(world.pose(1).position - before, [0, 0, RETREAT], atol=0.005)


@EACH_ENGINE
def test_a_cup_across_two_objects_does_not_seal(engine: EngineName) -> None:
    pose = np.eye(4)
    pose[:3, :3] = DOWN.as_matrix()
    pose[:3, 3] = [0.0, 0.0, SIDES[2]]
    turn = own_axes(box()).as_quat()
    with open_world(engine, [box(), box()], free_hand(with_cup())) as world:
        for shift, expected in ((0.031, Outcome.NO_SEAL), (0.05, Outcome.SUCCESS)):
            world.reset()
            for number, x in ((0, shift - 0.0615), (1, shift)):
                place = Pose(np.array([x, 0.0, SIDES[2] / 2]), turn)
                world.place(place, number=number)
            world.step(24)
            pose[0, 3] = 0.0 if expected == Outcome.NO_SEAL else shift
            assert execute_pose(world, pose, 0.0).outcome == expected

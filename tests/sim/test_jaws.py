"""The hand holds what friction can hold, and nothing else."""

import numpy as np
import pytest
import trimesh
from worlds import EACH_ARM, EACH_ENGINE, HAND, hand_at, start, twist

from egad.geometry import Bundle
from egad.grippers import GRIPPERS, Gripper
from egad.sim.arms import HandPose
from egad.sim.jaws import COLLISION_FORCE, Hand
from egad.sim.model import build
from egad.sim.parameters import EngineName
from egad.sim.world import Pose, UnstableError, World

BUNDLE = Bundle()
ROUND = Bundle(deviation=1e-5, max_vertices=1000)  # one part with all vertices
SIDE = 0.04
LIFT = 0.2
LIGHT = build(trimesh.creation.box((SIDE,) * 3), 400.0, BUNDLE)  # 26 g, simulated as 50
HEAVY = build(trimesh.creation.box((SIDE,) * 3), 3125.0, BUNDLE)  # 200 g
BALL = build(trimesh.creation.icosphere(4, 0.025), 400.0, ROUND)


def gripped(
    world: World, y: float = 0.0, tip: float = 0.01, arm: str = "axis"
) -> tuple[Hand, bool]:
    """Close on the object on the table; the hand, and whether both fingers press."""
    bottom = world.model.mesh.bounds[0, 2]
    world.place(Pose(np.array([0, 0, 0.0002 - bottom]), np.array([0, 0, 0, 1.0])))
    world.step(60)
    hand = hand_at(world, HandPose(0.0, y, tip, 0.0), 0.065, arm)
    hand.close()
    return hand, hand.pinches()


def bare(force: float) -> Gripper:
    """Pads of friction 0.5, and fingers that press with a force."""
    return HAND.model_copy(update={"force": force, "pads": "bare", "friction": 0.5})


@EACH_ENGINE
@EACH_ARM
def test_a_held_cube_does_not_creep(engine: EngineName, arm: str) -> None:
    """40 mm, 20 N, 10 s."""
    with start(engine, LIGHT, bare(20.0), arm) as world:
        hand, pinched = gripped(world, arm=arm)
        on_table = world.pose().position[2]
        hand.lift(LIFT, 1.0)
        before = world.pose()
        world.step(2400)  # 10 s
        after = world.pose()
        assert pinched
        assert hand.carries()
        assert before.position[2] - on_table == pytest.approx(LIFT, abs=0.001)
        np.testing.assert_allclose(after.position, before.position, atol=0.001)
        np.testing.assert_allclose(after.quaternion, before.quaternion, atol=0.01)


@EACH_ENGINE
@pytest.mark.parametrize("force", [20.0, 70.0, 100.0])
def test_fingers_stop_on_the_surface(engine: EngineName, force: float) -> None:
    with start(engine, LIGHT, bare(force)) as world:
        hand, _ = gripped(world)
        assert hand.opening() == pytest.approx(SIDE, abs=0.0005)
        for pressed in world.forces()[:2]:
            assert pressed == pytest.approx(force, rel=0.1)


@EACH_ENGINE
@pytest.mark.parametrize(("thickness", "force"), [(0.005, 100.0), (0.01, 70.0), (0.02, 20.0)])
def test_thin_light_plates_are_not_squeezed_flat(
    engine: EngineName, thickness: float, force: float
) -> None:
    model = build(trimesh.creation.box((0.04, 0.04, thickness)), 400.0, BUNDLE)
    standing = np.array([0.0, np.sqrt(0.5), 0.0, np.sqrt(0.5)])
    with start(engine, model, HAND.model_copy(update={"force": force})) as world:
        world.place(Pose(np.array([0.0, 0.0, 0.0202]), standing))
        world.step(30)
        hand = hand_at(world, HandPose(0.0, 0.0, 0.01, 0.0), 0.07)
        hand.close()
        hand.lift(LIFT, 1.0)
        soft = 0.001 if engine == "drake" else 0.0  # its pads are of silicone
        assert hand.opening() == pytest.approx(thickness, abs=0.0005 + soft)
        assert hand.carries()


@EACH_ENGINE
@EACH_ARM
def test_a_cube_held_only_at_its_rim_falls(engine: EngineName, arm: str) -> None:
    """1 mm of the cube between 20 mm wide pads; the same force holds it in the middle."""
    outcomes = []
    for y in (0.0, 0.029):
        with start(engine, HEAVY, bare(2.5), arm) as world:
            hand, pinched = gripped(world, y, arm=arm)
            hand.lift(LIFT, 1.0)
            world.step(240)
            outcomes.append((pinched, hand.carries(), world.pose().position[2] > LIFT / 2))
    assert outcomes == [(True, True, True), (True, False, False)]


@EACH_ENGINE
@pytest.mark.parametrize(("mass", "held"), [(1.0, True), (1.5, True), (2.5, False)])
def test_friction_carries_what_coulomb_allows(engine: EngineName, mass: float, held: bool) -> None:
    """Two pads with 20 N and a coefficient of 0.5 carry 20 N, 2.04 kg."""
    model = build(trimesh.creation.box((SIDE,) * 3), mass / SIDE**3, BUNDLE)
    with start(engine, model, bare(20.0)) as world:
        hand, _ = gripped(world)
        hand.lift(LIFT, 2.0)
        world.step(240)
        assert hand.carries() is held


@EACH_ENGINE
@pytest.mark.parametrize(("above", "held"), [(0.0, True), (0.005, True), (0.014, False)])
def test_a_ball_slips_out_below_pads_beyond_the_friction_angle(
    engine: EngineName, above: float, held: bool
) -> None:
    """5 mm above the equator the sides lean by 12 degrees, 14 mm above by 34; friction: 27."""
    with start(engine, BALL, bare(20.0)) as world:
        hand, _ = gripped(world, tip=0.025 + above)
        hand.lift(LIFT, 1.0)
        assert hand.carries() is held


@EACH_ENGINE
@pytest.mark.parametrize("pads", ["silicone", "bare"])
@pytest.mark.parametrize(("part", "turns"), [(0.8, False), (3.0, True)])
def test_pads_resist_twisting_as_pressed_discs(
    engine: EngineName, pads: str, part: float, turns: bool
) -> None:
    """Both pads touch a facet of 2 mm; friction force times 2/3 of the disc's radius."""
    force = 20.0
    gripper = HAND.model_copy(update={"force": force, "pads": pads})
    friction, radius = gripper.pad
    torque = part * 2 * friction * force * 2 / 3 * radius
    with start(engine, BALL, gripper) as world:
        world.place(Pose(np.array([0, 0, 0.025]), np.array([0, 0, 0, 1.0])))
        hand = hand_at(world, HandPose(0.0, 0.0, 0.025, 0.0), 0.065)
        hand.close()
        hand.lift(LIFT, 1.0)
        assert (spun(world, torque) > 1) is turns


def spun(world: World, torque: float) -> float:
    """How fast the object turns at most in half a second of a torque about x, rad/s."""
    fastest = 0.0
    for _ in range(120):
        twist(world, (torque, 0, 0))
        try:
            world.step()
        except UnstableError:  # it turned so fast that it flew out of the hand
            return float("inf")
        fastest = max(fastest, world.speeds()[1])
    return fastest


@EACH_ENGINE
@EACH_ARM
def test_a_hand_says_whether_it_was_lifted_all_the_way(engine: EngineName, arm: str) -> None:
    with start(engine, LIGHT, arm=arm) as world:
        hand = hand_at(world, HandPose(0.0, 0.0, 0.02, 0.0), 0.07, arm)
        assert hand.lift(0.4, 1.0)
        assert hand.lift(0.5, 1.5) is (arm == "axis")  # beyond the reach of a Panda


@EACH_ENGINE
def test_a_hand_closes_on_nothing(engine: EngineName) -> None:
    with start(engine, LIGHT, GRIPPERS["yumi"]) as world:
        hand = hand_at(world, HandPose(0.3, 0.0, 0.01, 0.5), 0.05)
        hand.close()
        assert hand.opening() == pytest.approx(0, abs=1e-4)
        assert not hand.pinches()
        assert not hand.carries()


@EACH_ENGINE
@EACH_ARM
def test_a_free_descent_arrives_and_a_blocked_one_stops(engine: EngineName, arm: str) -> None:
    with start(engine, LIGHT, arm=arm) as world:
        world.place(Pose(np.array([0, 0, SIDE / 2]), np.array([0, 0, 0, 1.0])))
        hand = hand_at(world, HandPose(0.0, 0.0, 0.1, 0.0), 0.075, arm)
        assert hand.move(0.005, 0.4) is None
        assert hand.height() == pytest.approx(0.005, abs=0.001)
        world.reset()
        world.place(Pose(np.array([0, 0, SIDE / 2]), np.array([0, 0, 0, 1.0])))
        onto = hand_at(world, HandPose(0.035, 0.0, 0.1, 0.0), 0.075, arm)
        assert onto.move(0.005, 0.4) > 0
        assert onto.height() > SIDE - 0.005
        assert world.forces().hand > COLLISION_FORCE

"""The simulated table obeys the physics that can be worked out by hand."""

import importlib.util
import subprocess
import sys
from typing import Any

import mujoco
import numpy as np
import pytest
import trimesh
from worlds import EACH_ARM, EACH_ENGINE, HAND, hand_at, start

from egad.errors import UserError
from egad.friction import TABLE
from egad.geometry import Bundle
from egad.sim import mujoco_world
from egad.sim.arms import ARMS, HandPose
from egad.sim.engines import open_world
from egad.sim.jaws import Hand
from egad.sim.model import Model, build
from egad.sim.mujoco_model import scene_spec
from egad.sim.parameters import EngineName, check_engine
from egad.sim.world import GRAVITY, TIME_STEP, Pose, UnstableError, World

BUNDLE = Bundle()
UPRIGHT = np.array([0.0, 0.0, 0.0, 1.0])
SIDE = 0.04
CUBE = build(trimesh.creation.box((SIDE,) * 3), 1000.0, BUNDLE)
RING = build(trimesh.creation.torus(0.03, 0.01), 1000.0, BUNDLE)


def at(x: float, y: float, z: float) -> Pose:
    return Pose(np.array([x, y, z]), UPRIGHT)


@EACH_ENGINE
def test_free_fall(engine: EngineName) -> None:
    with start(engine, CUBE) as world:
        world.place(at(0, 0, 2.0))
        world.step(120)
        fallen = 2.0 - world.pose().position[2]
    # PyBullet damps speeds by 4 % a second.
    assert fallen == pytest.approx(GRAVITY / 2 * (120 * TIME_STEP) ** 2, rel=0.02)


@EACH_ENGINE
def test_a_cube_rests_at_half_its_height(engine: EngineName) -> None:
    with start(engine, CUBE) as world:
        world.place(at(0, 0, SIDE / 2 + 0.002))
        world.step(240)
        assert world.pose().position[2] == pytest.approx(SIDE / 2, abs=0.0003)
        assert world.vertices()[:, 2].min() == pytest.approx(0, abs=0.0003)
        assert world.forces().support == pytest.approx(CUBE.mass * GRAVITY, rel=0.01)
        assert world.forces().hand == 0


@EACH_ENGINE
def test_mass_and_friction_change_with_a_reset_and_come_back(engine: EngineName) -> None:
    """The weight on the table, and how a pushing hand drags the object along."""

    def seen(world: World) -> list[float]:
        world.reset()
        world.place(at(0, 0, SIDE / 2))
        world.step(120)
        weight = world.forces().support
        hand = Hand(world, ARMS["axis"](HAND), HandPose(0, 0, 0.005, 0), 0.06)
        hand.close()
        hand.lift(0.1, 0.5)
        return [weight, *world.pose().position]

    with start(engine, CUBE) as world:
        first = seen(world)
        world.mass_factor, world.friction_factor = 2.5, 0.01
        heavy = seen(world)
        world.mass_factor, world.friction_factor = 1.0, 1.0
        again = seen(world)
    assert first == again
    assert first[0] == pytest.approx(CUBE.mass * GRAVITY, rel=0.01)
    assert heavy[0] == pytest.approx(2.5 * CUBE.mass * GRAVITY, rel=0.01)
    assert first[3] > 0.1  # held, and lifted
    assert heavy[3] < 0.03  # slipped out of the fingers


@EACH_ENGINE
@pytest.mark.parametrize("degrees", [15, 24, 30, 35])
def test_a_cube_slides_only_on_a_slope_beyond_the_friction_angle(
    engine: EngineName, degrees: float
) -> None:
    slope = np.radians(degrees)
    pull = max(np.sin(slope) - TABLE.friction * np.cos(slope), 0.0) * GRAVITY
    with start(engine, CUBE) as world:
        world.place(at(0, 0, SIDE / 2))
        world.step(60)
        world.set_gravity((GRAVITY * np.sin(slope), 0, -GRAVITY * np.cos(slope)))
        world.step(120)
        moved = world.pose().position[0]
    assert moved == pytest.approx(pull / 2 * 0.25, rel=0.25, abs=0.0005)


@pytest.fixture(scope="module")
def fine_ball() -> Model:
    return build(trimesh.creation.icosphere(4, 0.025), 1000.0, BUNDLE)


@EACH_ENGINE
def test_a_rolling_ball_comes_to_rest(engine: EngineName, fine_ball: Model) -> None:
    with start(engine, fine_ball) as world:
        world.place(at(0, 0, 0.025), (0.2, 0, 0), (0, 8, 0))
        world.step(24)
        assert world.speeds()[0] > 0.1
        world.step(480)
        assert max(world.speeds()) < 0.05


@EACH_ENGINE
@pytest.mark.parametrize(("x", "free"), [(0.0, True), (0.03, False)])
def test_the_hole_of_a_ring_is_free(engine: EngineName, x: float, free: bool) -> None:
    """A finger goes in; the engine would close the hole if it took the hull of the whole ring."""
    thin = HAND.model_copy(update={"finger_thickness": 0.01, "finger_width": 0.01})
    with start(engine, RING, thin) as world:
        world.place(at(0, 0, 0.01))
        hand = hand_at(world, HandPose(x, 0.0, 0.06, np.pi / 2), 0.0)
        assert (hand.move(0.005, 0.3) is None) is free


@EACH_ENGINE
@EACH_ARM
def test_reset_forgets_everything(engine: EngineName, arm: str) -> None:
    def tumble(world: World) -> Pose:
        world.place(Pose(np.array([0.01, 0.02, 0.15]), np.array([0.1, 0.5, 0.3, 0.8124])))
        world.step(200)
        return world.pose()

    with start(engine, RING, arm=arm) as world:
        first = tumble(world)
        hand_at(world, HandPose(0.0, 0.0, 0.1, 0.0), 0.05, arm).close()
        world.reset()
        second = tumble(world)
    with start(engine, RING, arm=arm) as world:
        third = tumble(world)
    for again in (second, third):
        np.testing.assert_array_equal(first.position, again.position)
        np.testing.assert_array_equal(first.quaternion, again.quaternion)


@EACH_ENGINE
@pytest.mark.parametrize(
    "velocity", [(np.nan, 0, 0), (0, np.nan, 0), (0, 0, np.nan), (8, 8, 0), (0, 0, 11)]
)
def test_an_object_that_is_shot_away_is_noticed(
    engine: EngineName, velocity: tuple[float, float, float]
) -> None:
    with start(engine, CUBE) as world:
        world.place(at(0, 0, 1), velocity)
        with pytest.raises(UnstableError):
            world.step()


@EACH_ENGINE
@pytest.mark.parametrize("position", [(0, 0, -0.2), (9, 0, 1), (np.nan, 0, 1)])
def test_an_object_that_went_astray_is_noticed(
    engine: EngineName, position: tuple[float, float, float]
) -> None:
    with start(engine, CUBE) as world:
        world.place(at(*position))
        with pytest.raises(UnstableError):
            world.pose()


def test_an_engine_that_is_not_there_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(UserError, match="did you mean pybullet"):
        check_engine("bullet")
    found = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name: None if name == "pybullet" else found(name)
    )
    check_engine("mujoco")
    with pytest.raises(UserError, match="pybullet is not installed"):
        check_engine("pybullet")
    with pytest.raises(UserError, match="pybullet is not installed"):
        open_world("pybullet", [])
    monkeypatch.setattr(importlib.util, "find_spec", lambda _: None)
    with pytest.raises(UserError, match=r"drake is not installed: pip install 'egad\[drake\]'"):
        check_engine("drake")


@EACH_ENGINE
def test_a_robot_that_is_nowhere_stops_nothing(engine: EngineName) -> None:
    """From as high as an object may be dropped."""
    with start(engine, CUBE) as world:
        for height in (3.2, 4.0):
            world.place(at(0, 0, height))
            world.step(60)
            assert world.pose().position[2] == pytest.approx(height - GRAVITY / 32, abs=0.03)


def test_a_warning_of_the_engine_is_no_result(monkeypatch: pytest.MonkeyPatch) -> None:
    """Too little memory for the contacts: MuJoCo would leave some of them out, and go on."""

    def cramped(*scene: Any) -> mujoco.MjSpec:
        spec = scene_spec(*scene)
        spec.memory = 40_000
        return spec

    monkeypatch.setattr(mujoco_world, "scene_spec", cramped)
    with start("mujoco", RING) as world:
        world.place(at(0, 0, 0.008))
        with pytest.raises(UnstableError):
            world.step(10)


@EACH_ENGINE
def test_forces_are_told_apart_by_object(engine: EngineName) -> None:
    """A cube on a cube: the table bears both, through the lower one."""
    with open_world(engine, [CUBE, CUBE.scaled(0.5)]) as world:
        world.place(at(0, 0, SIDE / 2), number=0)
        world.place(at(0, 0, 1.25 * SIDE + 0.001), number=1)
        world.step(240)
        weights = [model.mass * GRAVITY for model in world.models]
        assert world.forces(0).support == pytest.approx(sum(weights), rel=0.02)
        assert world.forces(1).support == 0
        assert world.forces().support == pytest.approx(sum(weights), rel=0.02)
        assert world.pose(1).position[2] == pytest.approx(1.25 * SIDE, abs=0.001)


@EACH_ENGINE
def test_several_objects_take_no_part_until_they_are_placed(engine: EngineName) -> None:
    with open_world(engine, [CUBE, CUBE]) as world:
        assert world.present() == []
        world.place(at(0, 0, SIDE / 2), number=1)
        world.step(120)
        assert world.present() == [1]
        assert world.speeds()[0] < 0.01
        world.park(1)
        assert world.present() == []
        world.place(at(0, 0, 0.5), number=1)
        world.step(60)
        assert world.pose(1).position[2] < 0.25  # it falls again


@EACH_ENGINE
def test_walls_hold_an_object_until_they_are_removed(engine: EngineName) -> None:
    with open_world(engine, [CUBE], walls=0.2) as world:
        for removed in (False, True):
            world.reset()
            if removed:
                world.remove_walls()
            world.place(at(0, 0, SIDE / 2), velocity=(2.0, 0.0, 0.0))
            world.step(60)
            assert (world.pose().position[0] > 0.1) == removed
            # Resetting raises them again
            world.reset()
            world.place(at(0, 0, SIDE / 2), velocity=(0.0, -2.0, 0.0))
            world.step(60)
            assert world.pose().position[1] > -0.1 + SIDE / 2 - 0.005


def test_loading_an_engine_says_nothing_and_what_comes_after_is_still_said() -> None:
    code = (
        "import sys; from egad.sim.engines import open_world; open_world('pybullet', []);"
        "print('later', file=sys.stderr)"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True)
    assert (run.stdout, run.stderr) == (b"", b"later\n")

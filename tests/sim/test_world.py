"""The simulated table obeys the physics that can be worked out by hand."""

import numpy as np
import pybullet
import pytest
import trimesh

from egad.pipeline.config import Bundle
from egad.sim.model import build
from egad.sim.world import GRAVITY, TABLE_FRICTION, TIME_STEP, Pose, UnstableError, World

BUNDLE = Bundle()
UPRIGHT = np.array([0.0, 0.0, 0.0, 1.0])
SIDE = 0.04
CUBE = build(trimesh.creation.box((SIDE,) * 3), 1000.0, BUNDLE)
RING = build(trimesh.creation.torus(0.03, 0.01), 1000.0, BUNDLE)


def at(x: float, y: float, z: float) -> Pose:
    return Pose(np.array([x, y, z]), UPRIGHT)


def test_free_fall() -> None:
    with World(CUBE) as world:
        world.place(at(0, 0, 2.0))
        world.step(120)
        fallen = 2.0 - world.pose().position[2]
    # The engine damps speeds by 4 % a second.
    assert fallen == pytest.approx(GRAVITY / 2 * (120 * TIME_STEP) ** 2, rel=0.02)


def test_a_cube_rests_at_half_its_height() -> None:
    with World(CUBE) as world:
        world.place(at(0, 0, SIDE / 2 + 0.002))
        world.step(240)
        assert world.pose().position[2] == pytest.approx(SIDE / 2, abs=0.0003)
        assert world.vertices()[:, 2].min() == pytest.approx(0, abs=0.0003)
        assert world.force(world.table, world.object) == pytest.approx(
            CUBE.mass * GRAVITY, rel=0.01
        )


@pytest.mark.parametrize("degrees", [15, 24, 30, 35])
def test_a_cube_slides_only_on_a_slope_beyond_the_friction_angle(degrees: float) -> None:
    slope = np.radians(degrees)
    pull = max(np.sin(slope) - TABLE_FRICTION * np.cos(slope), 0.0) * GRAVITY
    with World(CUBE) as world:
        world.place(at(0, 0, SIDE / 2))
        world.step(60)
        world.client.setGravity(GRAVITY * np.sin(slope), 0, -GRAVITY * np.cos(slope))
        world.step(120)
        moved = world.pose().position[0]
    assert moved == pytest.approx(pull / 2 * 0.25, rel=0.25, abs=0.0005)


def test_a_rolling_ball_comes_to_rest() -> None:
    ball = build(trimesh.creation.icosphere(4, 0.025), 1000.0, BUNDLE)
    with World(ball) as world:
        world.place(at(0, 0, 0.025))
        world.client.resetBaseVelocity(world.object, (0.2, 0, 0), (0, 8, 0))
        world.step(24)
        assert world.speeds()[0] > 0.1
        world.step(480)
        assert max(world.speeds()) < 0.05


def test_the_hole_of_a_ring_is_free() -> None:
    """The engine would close it if it took the hull of the whole ring."""
    with World(RING) as world:
        world.place(at(0, 0, 0.1))
        client = world.client
        shape = client.createCollisionShape(pybullet.GEOM_SPHERE, radius=0.005)
        turns = np.linspace(0, 2 * np.pi, 8, endpoint=False)
        places = [(0, 0, 0.1), *((0.03 * np.cos(t), 0.03 * np.sin(t), 0.1) for t in turns)]
        distances = []
        for place in places:
            probe = client.createMultiBody(0.1, shape, basePosition=place)
            closest = client.getClosestPoints(probe, world.object, 1.0)
            distances.append(min(point[8] for point in closest))
            client.removeBody(probe)
    # Of 20 mm from the center to the ring the probe takes 5, and the hulls of the parts some.
    assert 0.011 < distances[0] < 0.0151
    assert max(distances[1:]) < -0.005


def test_reset_forgets_everything() -> None:
    def tumble(world: World) -> Pose:
        world.place(Pose(np.array([0.01, 0.02, 0.15]), np.array([0.1, 0.5, 0.3, 0.8124])))
        world.step(200)
        return world.pose()

    with World(RING) as world:
        first = tumble(world)
        world.reset()
        second = tumble(world)
    with World(RING) as world:
        third = tumble(world)
    for again in (second, third):
        np.testing.assert_array_equal(first.position, again.position)
        np.testing.assert_array_equal(first.quaternion, again.quaternion)


@pytest.mark.parametrize(
    "velocity", [(np.nan, 0, 0), (0, np.nan, 0), (0, 0, np.nan), (8, 8, 0), (0, 0, 11)]
)
def test_an_object_that_is_shot_away_is_noticed(velocity: tuple[float, float, float]) -> None:
    with World(CUBE) as world:
        world.place(at(0, 0, 1))
        world.client.resetBaseVelocity(world.object, velocity)
        with pytest.raises(UnstableError):
            world.step()


@pytest.mark.parametrize("position", [(0, 0, -0.2), (9, 0, 1), (np.nan, 0, 1)])
def test_an_object_that_went_astray_is_noticed(position: tuple[float, float, float]) -> None:
    with World(CUBE) as world:
        world.place(at(*position))
        with pytest.raises(UnstableError):
            world.pose()


def test_pose_matrix_moves_the_mesh() -> None:
    quarter = Pose(np.array([1.0, 2.0, 3.0]), np.array([0, 0, np.sqrt(0.5), np.sqrt(0.5)]))
    np.testing.assert_allclose(quarter.matrix @ [1, 0, 0, 1], [1, 3, 3, 1], atol=1e-12)

"""Scenes are at rest, inside the workspace, and follow from the seed."""

import numpy as np
import pytest
import trimesh
from scipy.spatial import ConvexHull
from worlds import EACH_FAST_ENGINE

from egad.bench import SCENE_KINDS, WORKSPACE, RestingObject, SceneKind, make_scene, scenes
from egad.bench.scenes import BOX, settle_from
from egad.geometry import Bundle
from egad.random import generator
from egad.sim.engines import open_world
from egad.sim.model import build
from egad.sim.parameters import EngineName
from egad.sim.world import UnstableError, World

BLOCK = build(trimesh.creation.box((0.03, 0.04, 0.08)), 600.0, Bundle())
CAN = build(trimesh.creation.cylinder(0.02, 0.06, sections=24), 600.0, Bundle())
BALL = build(trimesh.creation.icosphere(3, 0.02), 600.0, Bundle())
MODELS = [BLOCK, CAN, BLOCK, CAN, BLOCK]


def same(first: list[RestingObject], second: list[RestingObject]) -> bool:
    numbers = [each.number for each in first] == [each.number for each in second]
    return numbers and all(
        np.array_equal(one.pose.position, other.pose.position)
        and np.array_equal(one.pose.quaternion, other.pose.quaternion)
        for one, other in zip(first, second, strict=True)
    )


def footprint(world: World, number: int) -> ConvexHull:
    return ConvexHull(world.vertices(number)[:, :2])


@EACH_FAST_ENGINE
@pytest.mark.parametrize("kind", SCENE_KINDS)
def test_scenes_are_at_rest_and_reproducible(engine: EngineName, kind: SceneKind) -> None:
    models = MODELS[:1] if kind == "single" else MODELS
    with open_world(engine, models, walls=BOX) as world:
        first = make_scene(world, kind, generator(1, "test", kind))
        assert len(first) >= len(models) - 1
        for each in first:
            assert np.abs(each.pose.position[:2]).max() <= WORKSPACE / 2
            assert world.vertices(each.number)[:, 2].min() > -0.002
        settled = settle_from(world, first)
        for before, after in zip(first, settled, strict=True):
            np.testing.assert_allclose(after.pose.position, before.pose.position, atol=0.003)
        assert same(make_scene(world, kind, generator(1, "test", kind)), first)
        assert not same(make_scene(world, kind, generator(2, "test", kind)), first)


def test_packed_objects_stand_apart_and_upright() -> None:
    """The block, which is highest along the z axis of its file, stands on its smallest face."""
    with open_world("mujoco", MODELS) as world:
        placed = make_scene(world, "packed", generator(0, "test"))
        assert len(placed) == len(MODELS)
        hulls = [footprint(world, each.number) for each in placed]
        for number, each in enumerate(placed):
            for other in hulls[:number]:
                # No corner of one within the other
                for one, two in ((hulls[number], other), (other, hulls[number])):
                    below = one.equations[:, :2] @ two.points.T + one.equations[:, 2:]
                    assert not (below < 0).all(axis=0).any()
            if MODELS[each.number] is BLOCK:
                height = np.ptp(world.vertices(each.number)[:, 2])
                assert height == pytest.approx(0.08, abs=0.001)


def test_a_pile_is_dropped_into_a_box() -> None:
    """Balls roll away, unless walls keep them together."""
    furthest = []

    def look(world: World) -> None:
        sides = [np.abs(world.pose(each).position[:2]).max() for each in world.present()]
        furthest.append(max(sides))

    for walls in (0.14, None):
        with (
            open_world("mujoco", [BALL] * 6, walls=walls) as world,
            pytest.MonkeyPatch.context() as patch,
        ):
            patch.setattr(type(world), "remove_walls", look)
            make_scene(world, "pile", generator(0, "test"))
    assert furthest[0] < 0.07 < furthest[-1]


def test_a_scene_that_stays_empty_is_no_scene() -> None:
    """It is tried again first."""
    with open_world("mujoco", [BALL]) as world, pytest.MonkeyPatch.context() as patch:
        patch.setattr(scenes, "in_workspace", lambda _: False)
        with pytest.raises(UnstableError, match="no object stays"):
            make_scene(world, "single", generator(0, "test"))
        answers = iter([False, False])
        patch.setattr(scenes, "in_workspace", lambda _: next(answers, True))
        assert len(make_scene(world, "single", generator(0, "test"))) == 1


def test_an_object_that_still_turns_does_not_lie_still() -> None:
    """A ball that spins on the spot has no speed."""
    with open_world("mujoco", [BALL]) as world, pytest.MonkeyPatch.context() as patch:
        steps: list[int] = []
        patch.setattr(type(world), "speeds", lambda _: (0.0, 1.0 if len(steps) < 300 else 0.0))
        patch.setattr(type(world), "step", lambda *_: steps.append(1))
        scenes.settle(world)
    assert len(steps) > 300


def test_what_leaves_the_workspace_is_removed() -> None:
    with open_world("mujoco", MODELS[:2]) as world:
        first = make_scene(world, "packed", generator(0, "test"))
        outside = first[0]._replace(
            pose=first[0].pose._replace(position=np.array([0.2, 0.0, 0.04]))
        )
        left = settle_from(world, [outside, first[1]])
        assert [each.number for each in left] == [1]
        assert world.present() == [1]

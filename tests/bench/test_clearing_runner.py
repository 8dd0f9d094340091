"""Tables are cleared by rules that any detector meets alike."""

from collections.abc import Sequence

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation
from worlds import EACH_ENGINE, EACH_FAST_ENGINE, HAND

from egad.bench import Clutter, RestingObject, proposed_by
from egad.bench.clearing_runner import ClearingRunner
from egad.bench.runner import Attempt, Propose
from egad.bench.scenes import BOX
from egad.detectors import Grasp, GraspPoses, Observation, cameras_around
from egad.geometry import Bundle
from egad.grasps import hand_poses
from egad.sim.engines import open_world
from egad.sim.model import build
from egad.sim.parameters import EngineName
from egad.sim.robots import free_hand
from egad.tables.outcomes import Outcome

BLOCK = build(trimesh.creation.box((0.03, 0.04, 0.05)), 600.0, Bundle())
MODELS = [BLOCK, BLOCK, BLOCK]
Generator = np.random.Generator


def from_above(center: np.ndarray, axis: np.ndarray) -> Grasp:
    pose = hand_poses(center[None], axis[None], np.array([[0, 0, -1.0]]))[0]
    return Grasp.of_pose(pose, 0.055, 1.0)


def knowing(_: Observation, present: Sequence[RestingObject], __: Generator) -> Grasp:
    """The block that is furthest from others, across its narrowest level side."""

    def clearance(each: RestingObject) -> float:
        away = [np.linalg.norm(each.pose.position - other.pose.position) for other in present]
        return float(sorted(away)[min(1, len(away) - 1)])

    block = max(present, key=clearance).pose
    axes = Rotation.from_quat(block.quaternion).as_matrix().T
    sides = MODELS[0].mesh.extents
    level = [number for number in range(3) if abs(axes[number, 2]) < 0.1]
    axis = axes[min(level, key=lambda number: sides[number])]
    axis[2] = 0
    return from_above(block.position, axis / np.linalg.norm(axis))


def nowhere(*_: object) -> Grasp:
    return from_above(np.array([0.0, 0.0, 0.3]), np.array([1.0, 0, 0]))


def in_turn(*proposals: Propose) -> Propose:
    """Each attempt asks the next one."""
    left = iter(proposals)

    def propose(
        observation: Observation, present: Sequence[RestingObject], rng: Generator
    ) -> Grasp | Outcome:
        return next(left)(observation, present, rng)

    return propose


def clear(propose: Propose, engine: EngineName = "mujoco") -> list[Attempt]:
    with open_world(engine, MODELS, free_hand(HAND)) as world:
        runner = ClearingRunner(world, Clutter())
        return list(runner.clear(propose, "packed", "none", 3))


@EACH_FAST_ENGINE
def test_a_round_ends_when_the_table_is_empty(engine: EngineName) -> None:
    attempts = clear(knowing, engine)
    assert [each.outcome for each in attempts] == [Outcome.SUCCESS] * 3
    assert [len(each.present) for each in attempts] == [3, 2, 1]
    assert sorted(each.held for each in attempts if each.held is not None) == [0, 1, 2]


def test_a_round_ends_after_two_failures_in_a_row() -> None:
    assert [each.outcome for each in clear(nowhere)] == [Outcome.MISSED] * 2
    attempts = clear(in_turn(nowhere, knowing, nowhere, nowhere, knowing))
    found = [each.outcome == Outcome.SUCCESS for each in attempts]
    assert found == [False, True, False, False]


@pytest.mark.parametrize(
    ("answer", "outcome"),
    [
        ((np.full((1, 4, 4), np.nan), [0.05], [1.0]), Outcome.NOT_FINITE),
        ((2 * np.eye(4)[None], [0.05], [1.0]), Outcome.NOT_RIGID),
        ((np.eye(4)[None], [0.5], [1.0]), Outcome.TOO_WIDE),
        ((np.empty((0, 4, 4)), [], []), Outcome.NO_GRASP),
        (None, Outcome.ERROR),
        (7, Outcome.ERROR),
    ],
)
def test_what_a_detector_does_wrong_is_an_outcome(answer: object, outcome: Outcome) -> None:
    def detect(_view: object, _gripper: object, _rng: object) -> GraspPoses:
        if answer is None:
            raise ValueError("no idea")
        return GraspPoses(*map(np.array, answer))  # type: ignore[call-overload]

    attempts = clear(proposed_by(detect, HAND))
    assert {each.outcome for each in attempts} == {outcome}
    assert len(attempts) == (1 if outcome == Outcome.NO_GRASP else 2)


@pytest.mark.parametrize("views", [1, 6])
def test_each_cloud_of_a_pile_lies_on_its_own_block(views: int) -> None:
    """Distances are those from boxes, in closed form; blocks touch, so a few points are at both."""
    with open_world("mujoco", MODELS, free_hand(HAND), BOX) as world:
        runner = ClearingRunner(world, Clutter())
        present = runner.begin("pile", 2)
        poses = cameras_around(np.zeros(3), views, 0.6, np.radians(30))
        observation = runner.observe(present, "none", poses, np.random.default_rng(0))
    cloud, clouds = observation.cloud, observation.object_clouds
    assert len(clouds) == len(present) == 3
    for number, own in enumerate(clouds):
        assert len(own.points) > 100
        away = np.stack([np.abs(_outside(own.points, each)) for each in present])
        assert (away[number] > away.min(axis=0) + 0.001).mean() < 0.001
        assert away[number].max() < 0.012  # what one camera sees is blurred by 4 voxels
    joined = np.column_stack([np.concatenate(each) for each in zip(*clouds, strict=True)])
    assert sorted(joined.tolist()) == sorted(np.column_stack(cloud).tolist())


def _outside(points: np.ndarray, block: RestingObject) -> np.ndarray:
    """Signed distances from a block."""
    local = Rotation.from_quat(block.pose.quaternion).inv().apply(points - block.pose.position)
    beyond = np.abs(local) - np.asarray(BLOCK.mesh.extents) / 2
    signed: np.ndarray = np.minimum(beyond.max(axis=1), 0)
    signed += np.linalg.norm(np.maximum(beyond, 0), axis=1)
    return signed


@EACH_ENGINE
def test_a_round_is_repeated_bit_by_bit(engine: EngineName) -> None:
    propose = in_turn(nowhere, knowing, lambda *_: Outcome.TOO_WIDE, nowhere)
    with open_world(engine, MODELS, free_hand(HAND)) as world:
        runner = ClearingRunner(world, Clutter())
        attempts = list(runner.clear(propose, "packed", "stereo", 3))
        tried = [each.grasp or each.outcome for each in attempts]
        again = list(runner.repeat(tried, "packed", 3))
    for one, other in zip(attempts, again, strict=True):
        assert (one.outcome, one.held, one.stopped) == (other.outcome, other.held, other.stopped)
        for before, after in zip(one.present, other.present, strict=True):
            np.testing.assert_array_equal(before.pose.position, after.pose.position)

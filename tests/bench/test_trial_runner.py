"""Attempts: what succeeds, what fails and how, and that each can be repeated alone."""

import numpy as np
import pytest
import trimesh
from worlds import EACH_ENGINE, EACH_FAST_ENGINE, HAND, start

from egad.bench import Attempt, InitialPose, RestingObject, TrialProtocol, TrialRunner
from egad.bench.trial_runner import DROP_HEIGHT, WORKSPACE
from egad.detectors import View
from egad.detectors.asking import Detector
from egad.detectors.base import Grasp
from egad.detectors.subprocess import DetectorTimeoutError
from egad.geometry import Bundle
from egad.grippers import Gripper
from egad.sim.arms import ARMS
from egad.sim.model import build
from egad.sim.parameters import EngineName
from egad.sim.world import Pose, World
from egad.tables.outcomes import Outcome

BUNDLE = Bundle()
AXIS = ARMS["axis"](HAND)
CUBE = trimesh.creation.box((0.04, 0.04, 0.04))


def always(shift: tuple[float, float, float], width: float = 0.07) -> Detector:
    """A detector that knows only where the object is, and grasps beside its top by `shift`."""

    def detect(view: View, _gripper: Gripper, _rng: np.random.Generator, /) -> list[Grasp]:
        points = view.points().reshape(-1, 3)
        standing = points[points[:, 2] > 0.005]
        x, y, z = standing.mean(axis=0) * [1, 1, 0] + [0, 0, standing[:, 2].max()] + shift
        return [Grasp((float(x), float(y), float(z)), 0.0, width, 0.0, 1.0)]

    return detect


def outcome(
    mesh: trimesh.Trimesh,
    detect: Detector,
    density: float = 400.0,
    engine: EngineName = "mujoco",
    **gripper: float,
) -> Attempt:
    hand = HAND.model_copy(update=gripper)
    with start(engine, build(mesh, density, BUNDLE), hand) as world:
        return TrialRunner(world, ARMS["axis"](hand), TrialProtocol()).attempt(detect, 5)


@EACH_ENGINE
def test_a_grasp_at_the_middle_succeeds(engine: EngineName) -> None:
    attempt = outcome(CUBE, always((0, 0, -0.03)), engine=engine)
    assert attempt.outcome == "success"


@EACH_FAST_ENGINE
def test_a_grasp_beside_the_object_misses(engine: EngineName) -> None:
    attempt = outcome(CUBE, always((0, 0.1, -0.03)), engine=engine)
    assert attempt.outcome == "missed"
    assert attempt.lifted == pytest.approx(0, abs=0.001)


@EACH_FAST_ENGINE
def test_a_finger_on_top_of_the_object_collides(engine: EngineName) -> None:
    assert outcome(CUBE, always((0.035, 0, -0.03)), engine=engine).outcome == "collided"


@EACH_FAST_ENGINE
def test_too_heavy_an_object_slips(engine: EngineName) -> None:
    middle, density = always((0, 0, -0.03)), 2.5 / 0.04**3
    attempt = outcome(CUBE, middle, density, engine, force=20.0, friction=0.5)
    assert attempt.outcome == "slipped_lifting"
    assert attempt.lifted < 0.05


@pytest.mark.parametrize(
    ("shift", "width", "name"),
    [
        ((0, 0, -0.03), 0.2, "too_wide"),
        ((0, 0, -0.03), -0.01, "too_wide"),
        ((0, 0, -0.03), np.inf, "not_finite"),
        ((0, np.nan, 0), 0.07, "not_finite"),
        ((0, 0, -0.1), 0.07, "below_table"),
    ],
)
def test_a_grasp_that_the_hand_cannot_do_is_named(
    shift: tuple[float, float, float], width: float, name: str
) -> None:
    attempt = outcome(CUBE, always(shift, width))
    assert (attempt.outcome, attempt.grasp, attempt.lifted) == (name, None, 0.0)
    assert attempt.end is attempt.rest


@pytest.mark.parametrize("answer", [None, 3, ["grasp"], [(0, 0, 0)]])
def test_an_answer_that_is_no_list_of_grasps_is_an_error(answer: object) -> None:
    assert outcome(CUBE, lambda *_: answer).outcome == "error"  # type: ignore[arg-type,return-value]


def test_a_detector_that_takes_too_long_has_failed() -> None:
    def slow(*_: object) -> list[Grasp]:
        raise DetectorTimeoutError

    assert outcome(CUBE, slow).outcome == "timeout"


def test_an_object_larger_than_the_view_fails() -> None:
    huge = trimesh.creation.box((0.5, 0.5, 0.5))
    assert outcome(huge, always((0, 0, 0))).outcome == "failed"


@pytest.mark.parametrize(
    ("end", "outcome", "begun"),
    [
        ((0.05, 0.03, 0.02), "missed", "left"),
        ((0.15, 0.0, 0.02), "missed", "dropped"),
        ((0.3, 0.0, 0.02), "slipped_lifting", "dropped"),
        ((0.0, 0.0, 0.0201), "collided", "dropped"),
        ((0.0, 0.0, 0.42), "success", "from_hand"),
        (None, "failed", "dropped"),
    ],
)
def test_how_an_attempt_begins(
    end: tuple[float, float, float] | None, outcome: str, begun: str
) -> None:
    """From the hand after a success; put back where it left the workspace or was not touched."""
    upright = [0.0, 0.0, 0.0, 1.0]
    rest = Pose.of([0.0, 0.0, 0.02, *upright])
    last = Pose.of([*end, *upright]) if end else None
    before = Attempt(
        Outcome(outcome),
        (RestingObject(0, rest),),
        start=InitialPose("dropped", rest),
        end=last,
    )
    with start("mujoco", build(CUBE, 400.0, BUNDLE)) as world:
        runner = TrialRunner(world, AXIS, TrialProtocol())
        after = runner.attempt(always((0, 0, -0.03)), 3, before)
    assert after.start is not None
    assert after.rest is not None
    assert after.start.kind == begun
    assert np.linalg.norm(after.rest.position[:2]) < WORKSPACE
    if begun == "from_hand":
        begin = after.start.pose.matrix
        lowest = (CUBE.vertices @ begin[:3, :3].T + begin[:3, 3])[:, 2].min()
        assert lowest == pytest.approx(DROP_HEIGHT)
        assert -1e-9 < begin[2, 2] < 1 - 1e-9  # tilted, by 90 degrees at most


@EACH_FAST_ENGINE
@pytest.mark.parametrize("velocity", [(200.0, 0.0, 0.0), (np.nan, 0.0, 0.0)])
def test_an_object_that_explodes_has_failed_and_the_next_attempt_begins_anew(
    engine: EngineName,
    velocity: tuple[float, float, float],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("egad.bench.trial_runner.DROP_HEIGHT", 0.05)  # it explodes above that

    def explode(world: World) -> None:
        if 0.1 < world.pose().position[2] < 0.11 and world.forces().support == 0:
            world.place(world.pose(), velocity)

    with start(engine, build(CUBE, 400.0, BUNDLE)) as world:
        runner = TrialRunner(world, AXIS, TrialProtocol())
        world.watch = explode
        first = runner.attempt(always((0, 0, -0.03)), 3)
        world.watch = None
        second = runner.attempt(always((0, 0, -0.03)), 4, first)
    assert (first.outcome, first.end, first.lifted) == ("failed", None, 0.0)
    assert second.outcome == "success"
    assert second.start is not None
    assert second.start.kind == "dropped"

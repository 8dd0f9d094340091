"""One grasp trial: drop the object, take an image, plan, approach, close, lift, hold."""

import logging
from contextlib import nullcontext
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from egad.detectors.base import Detector, Grasp, best
from egad.detectors.labels import Labels
from egad.detectors.subprocess import DetectorTimeoutError
from egad.errors import UserError
from egad.grasps.gripper import Gripper
from egad.outcomes import Outcome
from egad.perception.camera import Eye, Intrinsics, View, above
from egad.perception.noise import noisy
from egad.sim.arms import CARRIERS, Stance, UnreachableError
from egad.sim.gripper import HEAVIEST, Hand
from egad.sim.initial_pose import Start, moved, starts
from egad.sim.parameters import Lifting, Trials
from egad.sim.settling import Stillness
from egad.sim.world import GRAVITY, TIME_STEP, Pose, UnstableError, World

START_ABOVE = 0.02  # fingertips start this far above the object
DESCENT_SPEED = 0.25  # mean, m/s
LIFT_SPEED = 0.35  # mean, m/s


class Execution(NamedTuple):
    """What came of a grasp.

    Attributes:
        outcome: One of `egad.outcomes.EXECUTION`, or failed.
        lifted: Height that the object's centre of mass gained, metres.
        end: Where the object is at last; None if the simulation broke down. Of an object that lay
            still in the hand before it was lifted all the way, where it would be then.
    """

    outcome: Outcome
    lifted: float
    end: Pose | None


def execute(
    world: World, gripper: Gripper, lifting: Lifting, grasp: Grasp, *, afloat: bool = False
) -> Execution:
    """Approach from above, close, lift and hold.

    It depends on the arguments alone, if the world was reset before the object was placed.

    Args:
        world: With the object where it is to be grasped.
        gripper: The hand; it is added to the world.
        lifting: Arm, lift and hold.
        grasp: One that the hand can do (`Grasp.flaw`).
        afloat: Whether the object floats in the air: held there until the hand has come, free but
            without weight until the fingers have closed.
    """
    try:
        before = world.pose().position[2]
        outcome, end = _outcome(world, gripper, lifting, grasp, afloat)
    except UnstableError:
        return Execution(Outcome.FAILED, 0.0, None)
    return Execution(outcome, float(end.position[2] - before), end)


def _outcome(
    world: World, gripper: Gripper, lifting: Lifting, grasp: Grasp, afloat: bool
) -> tuple[Outcome, Pose]:
    start = max(float(world.vertices()[:, 2].max()) + START_ABOVE, grasp.tip)
    try:
        hand = hung(world, gripper, lifting.arm, grasp, start)
    except UnreachableError:
        return Outcome.COLLIDED, world.pose()
    world.pull(0.0 if afloat else GRAVITY)
    with world.pinned() if afloat else nullcontext():
        if not hand.move(grasp.tip, (start - grasp.tip) / DESCENT_SPEED):
            return Outcome.COLLIDED, world.pose()
    touched = hand.close()
    world.pull(GRAVITY)
    if not hand.pinches():
        return Outcome.SLIPPED_CLOSING if touched else Outcome.MISSED, world.pose()
    return _carried(hand, lifting)


def _carried(hand: Hand, lifting: Lifting) -> tuple[Outcome, Pose]:
    """Lift and hold; what lies still in the hand stays there, and need not be simulated on."""
    height, seconds = lifting.lift_height, lifting.lift_height / LIFT_SPEED
    still = Stillness(hand, HEAVIEST * seconds, seconds + lifting.hold_time)
    arrived = hand.lift(height, seconds, still)
    if not hand.carries():
        return Outcome.SLIPPED_LIFTING, hand.world.pose()
    if not arrived:
        return Outcome.COLLIDED, hand.world.pose()
    if not hand.path_left:
        hand.hold(lifting.hold_time, still)
    outcome = Outcome.SUCCESS if hand.carries() else Outcome.DROPPED
    pose = hand.world.pose()
    rise = hand.path_left[-1] - hand.height() if hand.path_left else 0.0
    if hand.world.watch is not None:
        hand.go_on(lifting.hold_time)
    return outcome, Pose(pose.position + np.array([0.0, 0.0, rise]), pose.quaternion)


def hung(world: World, gripper: Gripper, arm: str, grasp: Grasp, height: float) -> Hand:
    """The open hand, its fingertips at some height above a grasp.

    Raises:
        UnreachableError: The arm cannot bring it there.
    """
    stance = Stance(grasp.center[0], grasp.center[1], height, grasp.angle)
    return Hand(world, gripper, CARRIERS[arm](world, gripper, stance), grasp.width)


log = logging.getLogger(__name__)
Floats = NDArray[np.float64]

SETTLING_TIME = 4.0
REST_SPEED = 0.003  # m/s
REST_TURNING = 0.05  # rad/s
REST_TIME = 0.1


@dataclass(frozen=True)
class Attempt:
    """What came of an attempt.

    Attributes:
        outcome: As of `Execution`, or one of `egad.outcomes.DETECTOR_FAILURES`; None if it was
            repeated without a grasp, for why there was none is not known.
        start: Where the object fell from; None if it never lay still.
        rest: Where it lay when the camera looked.
        grasp: What was tried, if it came to that.
        lifted: Height that the object's centre of mass gained, metres.
        end: Where it was at last; None if the simulation broke down.
    """

    outcome: Outcome | None
    start: Start | None = None
    rest: Pose | None = None
    grasp: Grasp | None = None
    lifted: float = 0.0
    end: Pose | None = None


class Ready(NamedTuple):
    """An object that lies still in the workspace.

    Attributes:
        start: Where it fell from.
        rest: Where it lies.
    """

    start: Start
    rest: Pose


class Bench:
    """A table with an object, a camera and a hand, to try grasps on."""

    def __init__(self, world: World, gripper: Gripper, trials: Trials) -> None:
        """Set up.

        Args:
            world: A running simulation.
            gripper: The hand.
            trials: Camera, workspace and lift.
        """
        self.world = world
        self.gripper = gripper
        self.trials = trials
        self.eye = Eye(world.model.mesh)
        self.intrinsics = Intrinsics.spanning(*trials.image, trials.field_of_view)
        self.camera = above(trials.camera_height)

    def attempt(
        self, detect: Detector | Labels, seed: int, before: Attempt | None = None
    ) -> Attempt:
        """One attempt, from drop to hold; it depends on the arguments alone.

        Args:
            detect: The grasp detector.
            seed: For the drops and, apart from these, for the detector and for the camera.
            before: The attempt before, if the object goes on from there.
        """
        drop_rng, detector_rng, camera_rng = np.random.default_rng(seed).spawn(3)
        ready = self._begin(drop_rng, before)
        if ready is None:
            return Attempt(Outcome.FAILED)
        view = self.look()
        if self.trials.depth_noise > 0:
            view = noisy(view, self.trials.depth_noise, camera_rng)
        grasp = self._plan(detect, view, detector_rng)
        if isinstance(grasp, Outcome):
            return Attempt(grasp, *ready, end=ready.rest)
        return self._carried_out(grasp, ready)

    def repeat(self, start: Start, grasp: Grasp | None) -> Attempt:
        """An attempt again, without its detector: what it began with and what was proposed.

        Args:
            start: Where the object falls from.
            grasp: What is tried, if anything.

        Returns:
            The same as the first time, bit by bit, but no name for why there is no grasp.
        """
        rest = self._settled(start)
        if rest is None:
            return Attempt(Outcome.FAILED)
        ready = Ready(start, rest)
        if grasp is None:
            return Attempt(None, *ready, end=rest)
        return self._carried_out(grasp, ready)

    def look(self) -> View:
        """A depth image of the object where it is now."""
        return self.eye.look(self.world.pose().matrix, self.intrinsics, self.camera)

    def _carried_out(self, grasp: Grasp, ready: Ready) -> Attempt:
        result = execute(self.world, self.gripper, self.trials, grasp)
        return Attempt(result.outcome, *ready, grasp, result.lifted, result.end)

    def _plan(
        self, detect: Detector | Labels, view: View, rng: np.random.Generator
    ) -> Grasp | Outcome:
        """The grasp to try, or the outcome if there is none; a detector may fail as it likes."""
        place = self.world.pose().matrix @ self.world.model.to_principal
        try:
            if isinstance(detect, Labels):
                return best(detect.propose(place, view, self.gripper), self.gripper)
            return best(detect(view, self.gripper, rng), self.gripper)
        except (UserError, MemoryError):
            raise
        except DetectorTimeoutError as error:
            log.warning("the detector was stopped: %s", error)
            return Outcome.TIMEOUT
        except Exception as error:
            log.warning("the detector failed: %s: %s", type(error).__name__, error)
            return Outcome.ERROR

    def _begin(self, rng: np.random.Generator, before: Attempt | None) -> Ready | None:
        """Drop the object, or leave it, until it lies still in the workspace."""
        mesh = self.world.model.mesh
        left = None if self.trials.between == "anew" or before is None else self._left_by(before)
        for start in starts(mesh, self.trials.drop_height, left, rng):
            rest = self._settled(start)
            if rest is not None and self._in_workspace(rest):
                return Ready(start, rest)
        return None

    def _left_by(self, before: Attempt) -> Start | None:
        """Where an attempt left the object; None if it is put back.

        That is done if the simulation broke down, and for an object that hardly moved: a detector
        would try the same again.
        """
        if before.end is None or before.rest is None:
            return None
        if before.outcome == Outcome.SUCCESS:
            return Start("from_hand", before.end)
        elsewhere = moved(self.world.model.mesh, before.rest, before.end)
        return Start("left", before.end) if elsewhere else None

    def _settled(self, start: Start) -> Pose | None:
        """Let the object fall in an empty world until it lies still; None if it never does."""
        self.world.reset()
        self.world.place(start.pose)
        pause = round(REST_TIME / TIME_STEP)
        still = 0
        try:
            for _ in range(round(SETTLING_TIME / TIME_STEP)):
                self.world.step()
                speed, turning = self.world.speeds()
                still = still + 1 if speed < REST_SPEED and turning < REST_TURNING else 0
                if still == pause:
                    return self.world.pose()
        except UnstableError as error:
            log.warning("the object did not come to rest: %s", error)
        return None

    def _in_workspace(self, rest: Pose) -> bool:
        """Whether the object is near the middle, and the camera sees all of it."""
        if np.linalg.norm(rest.position[:2]) > self.trials.workspace:
            return False
        seen = (self.world.vertices() - self.camera[:3, 3]) @ self.camera[:3, :3]
        return self.intrinsics.sees(seen)

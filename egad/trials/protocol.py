"""The protocol of a trial: drop, look, plan, approach, close, lift, hold."""

import logging
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from egad.errors import UserError
from egad.settings import Gripper, Trials
from egad.trials.child import DetectorTimeoutError
from egad.trials.execution import execute
from egad.trials.grasp import Grasp, best
from egad.trials.labelled import Labels
from egad.trials.policies import Detector
from egad.trials.starts import Start, moved, starts
from egad.trials.world import TIME_STEP, Pose, UnstableError, World
from egad.vision.camera import Eye, Intrinsics, View, above
from egad.vision.noise import noisy

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
        outcome: As of `Execution`; or failed: no state to grasp from. If it did not come to a
            grasp: no_grasp: none was proposed; not_finite, too_wide or below_table: none was that
            the hand can do (`Grasp.flaw`); error: the detector broke down or gave no grasps;
            timeout: it took too long.
        start: Where the object fell from; None if it never lay still.
        rest: Where it lay when the camera looked.
        grasp: What was tried, if it came to that.
        lifted: Height that the object's centre of mass gained, metres.
        end: Where it was at last; None if the simulation broke down.
    """

    outcome: str
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
            return Attempt("failed")
        view = self.look()
        if self.trials.depth_noise > 0:
            view = noisy(view, self.trials.depth_noise, camera_rng)
        grasp = self._plan(detect, view, detector_rng)
        if isinstance(grasp, str):
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
            return Attempt("failed")
        ready = Ready(start, rest)
        if grasp is None:
            return Attempt("", *ready, end=rest)
        return self._carried_out(grasp, ready)

    def look(self) -> View:
        """A depth image of the object where it is now."""
        return self.eye.look(self.world.pose().matrix, self.intrinsics, self.camera)

    def _carried_out(self, grasp: Grasp, ready: Ready) -> Attempt:
        result = execute(self.world, self.gripper, self.trials, grasp)
        return Attempt(result.outcome, *ready, grasp, result.lifted, result.end)

    def _plan(self, detect: Detector | Labels, view: View, rng: np.random.Generator) -> Grasp | str:
        """The grasp to try, or the outcome if there is none; a detector may fail as it likes."""
        place = self.world.pose().matrix @ self.world.model.to_principal
        try:
            if isinstance(detect, Labels):
                return best(detect.propose(place, view, self.gripper), self.gripper)
            return best(detect(view, self.gripper, rng), self.gripper)
        except UserError:
            raise
        except DetectorTimeoutError as error:
            log.warning("the detector was stopped: %s", error)
            return "timeout"
        except Exception as error:
            log.warning("the detector failed: %s: %s", type(error).__name__, error)
            return "error"

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
        if before.outcome == "success":
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

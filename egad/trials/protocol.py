"""The protocol of a trial: drop, look, plan, approach, close, lift, hold."""

import logging
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
import trimesh
from numpy.typing import NDArray

from egad.errors import RejectedError, UserError
from egad.seeds import entropy
from egad.settings import Gripper, Trials
from egad.stage_settings import SimulatedTrials
from egad.tables.evaluation import TRIALS
from egad.trials.camera import Eye, Intrinsics, View, above
from egad.trials.child import DetectorTimeoutError
from egad.trials.grasp import Grasp, best
from egad.trials.hand import Hand, Stance
from egad.trials.labelled import Labels
from egad.trials.model import Model, build
from egad.trials.policies import Detector
from egad.trials.world import TIME_STEP, Pose, UnstableError, World

log = logging.getLogger(__name__)
Floats = NDArray[np.float64]

DROP_CLEARANCE = 0.05  # between the table and the lowest point of the object
DROP_SPREAD = 0.03  # the centre of mass is dropped at most this far from the middle, both ways
DROPS = 5
SETTLING_TIME = 4.0
REST_SPEED = 0.003  # m/s
REST_TURNING = 0.05  # rad/s
REST_TIME = 0.1
START_ABOVE = 0.02  # fingertips start this far above the object
DESCENT_SPEED = 0.25  # mean, m/s
LIFT_SPEED = 0.35  # mean, m/s


@dataclass(frozen=True)
class Attempt:
    """What came of an attempt.

    Attributes:
        outcome: success; or collided: stopped on the way down; missed: the fingers closed, but
            do not both press on the object; slipped: lost while lifting; dropped: lost while held
            up; failed: no state to grasp from, or the simulation broke down. If it did not come
            to a grasp: no_grasp: none was proposed; not_finite, too_wide or below_table: none was
            that the hand can do (`Grasp.flaw`); error: the detector broke down or gave no grasps;
            timeout: it took too long.
        grasp: What was tried, if it came to that.
        lifted: Height that the object's centre of mass gained, metres.
    """

    outcome: str
    grasp: Grasp | None
    lifted: float


class Bench:
    """A table with an object, a camera and a hand, to try grasps on."""

    def __init__(self, world: World, gripper: Gripper, trials: Trials) -> None:
        """Set up.

        Args:
            world: A running simulation.
            gripper: The hand.
            trials: Camera and lift.
        """
        self.world = world
        self.gripper = gripper
        self.trials = trials
        self.eye = Eye(world.model.mesh)
        self.intrinsics = Intrinsics.square(trials.image_size, trials.field_of_view)
        self.camera = above(trials.camera_height)

    def attempt(self, detect: Detector | Labels, seed: int) -> Attempt:
        """One attempt, from drop to hold. It depends on the seed and on nothing before it.

        Args:
            detect: The grasp detector.
            seed: For the drops and, apart from these, for the detector.
        """
        drop_rng, detector_rng = np.random.default_rng(seed).spawn(2)
        self.world.reset()
        try:
            if not self._drop(drop_rng):
                return Attempt("failed", None, 0.0)
            grasp = self._plan(detect, detector_rng)
            if isinstance(grasp, str):
                return Attempt(grasp, None, 0.0)
            before = self.world.pose().position[2]
            outcome = self._execute(grasp)
            return Attempt(outcome, grasp, float(self.world.pose().position[2] - before))
        except UnstableError:
            return Attempt("failed", None, 0.0)

    def look(self) -> View:
        """A depth image of the object where it is now."""
        return self.eye.look(self.world.pose().matrix, self.intrinsics, self.camera)

    def _plan(self, detect: Detector | Labels, rng: np.random.Generator) -> Grasp | str:
        """The grasp to try, or the outcome if there is none; a detector may fail as it likes."""
        view = self.look()
        try:
            if isinstance(detect, Labels):
                place = self.world.pose().matrix @ self.world.model.to_principal
                return best(detect.propose(place, view, self.gripper), self.gripper)
            return best(detect(view, self.gripper, rng), self.gripper)
        except (UserError, UnstableError):
            raise
        except DetectorTimeoutError as error:
            log.warning("the detector was stopped: %s", error)
            return "timeout"
        except Exception as error:
            log.warning("the detector failed: %s: %s", type(error).__name__, error)
            return "error"

    def _drop(self, rng: np.random.Generator) -> bool:
        """Drop the object until it lies still within view; False if it never does."""
        for _ in range(DROPS):
            self.world.place(_drop_pose(self.world.model, rng))
            if self._settle() and self._in_view():
                return True
        return False

    def _settle(self) -> bool:
        """Wait until the object lies still; False if it does not in time."""
        pause = round(REST_TIME / TIME_STEP)
        still = 0
        for _ in range(round(SETTLING_TIME / TIME_STEP)):
            self.world.step()
            speed, turning = self.world.speeds()
            still = still + 1 if speed < REST_SPEED and turning < REST_TURNING else 0
            if still == pause:
                return True
        return False

    def _in_view(self) -> bool:
        """Whether the camera sees all of the object."""
        points = self.world.vertices() - self.camera[:3, 3]
        ahead = points @ self.camera[:3, :3]
        limit = np.tan(np.radians(self.trials.field_of_view) / 2)
        return bool((np.abs(ahead[:, :2]) <= limit * ahead[:, 2:]).all())

    def _execute(self, grasp: Grasp) -> str:
        """Carry out a grasp and name the outcome."""
        start = float(self.world.vertices()[:, 2].max()) + START_ABOVE
        start = max(start, grasp.tip)
        stance = Stance(grasp.center[0], grasp.center[1], start, grasp.angle)
        hand = Hand(self.world, self.gripper, stance, grasp.width)
        if not hand.move(grasp.tip, (start - grasp.tip) / DESCENT_SPEED):
            return "collided"
        hand.close()
        if not hand.pinches():
            return "missed"
        hand.lift(self.trials.lift_height, self.trials.lift_height / LIFT_SPEED)
        if not hand.carries():
            return "slipped"
        self.world.step(round(self.trials.hold_time / TIME_STEP))
        return "success" if hand.carries() else "dropped"


def run(
    mesh: trimesh.Trimesh,
    label: str,
    object_id: str,
    detect: Detector | Labels,
    settings: SimulatedTrials,
) -> pd.DataFrame:
    """Try to grasp an object again and again, each time dropped anew (after EGAD, section V).

    Attempts differ from the paper's in that each begins with a drop from 5 cm in a random
    orientation, whether or not the one before succeeded: so each can be repeated alone.

    Args:
        mesh: Closed surface in metres, scaled for the gripper.
        label: Name in the evaluation set.
        object_id: Name of the object; with the seed of the settings it decides all drops, so that
            two detectors face the same ones.
        detect: The grasp detector; whatever it does wrong is the outcome of the attempt.
        settings: Gripper, material and trials.

    Returns:
        One row an attempt, columns of `tables.evaluation.TRIALS`. An object without convex parts
        has failed attempts only.
    """
    trials = settings.trials
    seeds = [entropy(settings.seed, "trial", object_id, n) for n in range(trials.attempts)]
    try:
        model = build(mesh, settings.material.density, trials.max_parts, trials.volume_error)
    except RejectedError as reason:
        log.warning("%s (%s) cannot be simulated: %s", label, object_id, reason)
        attempts = [Attempt("failed", None, 0.0)] * len(seeds)
        known: dict[str, Any] = {"parts": 0, "volume_error": np.nan}
    else:
        with World(model) as world:
            bench = Bench(world, settings.gripper, trials)
            attempts = [bench.attempt(detect, seed) for seed in seeds]
        known = {"parts": len(model.parts), "volume_error": model.volume_error}
    known |= {"label": label, "id": object_id}
    rows = [
        known | {"attempt": number, "seed": f"{seed:032x}"} | _columns(attempt)
        for number, (seed, attempt) in enumerate(zip(seeds, attempts, strict=True))
    ]
    return pd.DataFrame(rows, columns=TRIALS.names)


def _columns(attempt: Attempt) -> dict[str, Any]:
    grasp = attempt.grasp
    center = grasp.center if grasp else (np.nan,) * 3
    return {
        "success": attempt.outcome == "success",
        "outcome": attempt.outcome,
        **dict(zip(("grasp_x", "grasp_y", "grasp_z"), center, strict=True)),
        "angle": grasp.angle if grasp else np.nan,
        "width": grasp.width if grasp else np.nan,
        "quality": grasp.quality if grasp else np.nan,
        "lifted": attempt.lifted,
    }


def _drop_pose(model: Model, rng: np.random.Generator) -> Pose:
    """A random orientation, uniform over all, just above the middle of the table."""
    quaternion = rng.normal(size=4)
    quaternion /= np.linalg.norm(quaternion)
    x, y = rng.uniform(-DROP_SPREAD, DROP_SPREAD, size=2)
    turned = model.mesh.vertices @ Pose(np.zeros(3), quaternion).matrix[2, :3]
    return Pose(np.array([x, y, DROP_CLEARANCE - turned.min()]), quaternion)

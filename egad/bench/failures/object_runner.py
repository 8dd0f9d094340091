"""A table with one object to try grasps on: dropped, seen by a detector, and grasped.

Grasps from above need a hand on a vertical axis and a camera above (`TrialRunner`); grasps from any
direction need a hand without an arm and six cameras (`ClearingRunner`). Both have one interface.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import islice

import numpy as np
import pandas as pd
from typing_extensions import override

from egad.bench.clearing_runner import ClearingRunner, camera_poses
from egad.bench.parameters import Clutter, ContactRule, TrialProtocol
from egad.bench.protocols import SceneCameras
from egad.bench.scene_labels import SceneLabels
from egad.bench.scenes import RestingObject, make_scene, put
from egad.bench.trial_runner import TrialRunner
from egad.detectors import (
    Answer,
    Detector,
    Failure,
    Grasp,
    Labels,
    NoiseName,
    Observation,
    View,
    from_above,
    ranked,
    seen_by,
    try_to_plan,
)
from egad.grippers import Gripper
from egad.sim import (
    ARMS,
    EngineName,
    Model,
    Pose,
    UnstableError,
    World,
    execute_pose,
    free_hand,
    open_world,
)
from egad.tables.outcomes import Outcome

MIN_DOWN = np.cos(np.radians(10))  # of the approach of a grasp that is executed from above
MAX_PROPOSALS = 10


class ObjectRunner(ABC):
    """A table with one object; the result of each method depends only on its arguments."""

    engine: EngineName
    gripper: Gripper
    world: World  # the table with the object and the hand

    @abstractmethod
    def drop(self, rng: np.random.Generator) -> Pose | None:
        """Drop the object; where it lies, or None if never still where the cameras see it."""

    def propose(
        self, detect: Detector, rest: Pose, rng: np.random.Generator
    ) -> list[Grasp] | Outcome | Failure:
        """At most ten executable grasps of a detector, best first; or why there is none."""
        camera_rng, detector_rng = rng.spawn(2)

        def plan() -> list[Grasp] | Outcome:
            seen = self._observe(rest, camera_rng)
            answer: Answer
            if isinstance(seen, View):
                answer = from_above(detect(seen, self.gripper, detector_rng))
            else:
                answer = detect(seen_by(detect, seen), self.gripper, detector_rng)
            return ranked(answer, self.gripper, MAX_PROPOSALS)

        return try_to_plan(plan)

    @abstractmethod
    def labelled(self, rest: Pose) -> list[Grasp]:
        """Labelled grasps that are possible where the object lies, best first."""

    @abstractmethod
    def execute(self, rest: Pose, grasp: Grasp) -> Outcome:
        """Execute a grasp."""

    def can_do(self, grasp: Grasp) -> bool:
        """Whether the hand can execute a grasp."""
        return grasp.infeasibility(self.gripper) is None

    @abstractmethod
    def _observe(self, rest: Pose, rng: np.random.Generator) -> View | Observation:
        """What the cameras see of the object."""


class RunnerFromAbove(ObjectRunner):
    """Grasps straight from above."""

    def __init__(self, runner: TrialRunner, grasps: pd.DataFrame) -> None:
        """Set up with a world of the object and its labelled grasps."""
        self.engine, self.gripper = runner.trials.engine, runner.gripper
        self.world = runner.world
        self._runner, self._labels = runner, Labels(grasps)

    @override
    def drop(self, rng: np.random.Generator) -> Pose | None:
        ready = self._runner.begin(rng)
        return None if ready is None else ready.rest

    @override
    def labelled(self, rest: Pose) -> list[Grasp]:
        self._place(rest)
        matrix = rest.matrix @ self.world.model.to_principal
        found = self._labels.propose(matrix, self._runner.render_view(), self.gripper)
        grasps = ranked(found, self.gripper, MAX_PROPOSALS)
        return [] if isinstance(grasps, Outcome) else grasps

    @override
    def execute(self, rest: Pose, grasp: Grasp) -> Outcome:
        outcome = self._runner.carry_out(rest, grasp.from_above(self.gripper)).outcome
        return outcome or Outcome.FAILED

    @override
    def can_do(self, grasp: Grasp) -> bool:
        return -grasp.pose[2, 2] >= MIN_DOWN and super().can_do(grasp)

    @override
    def _observe(self, rest: Pose, rng: np.random.Generator) -> View:
        self._place(rest)
        return self._runner.noisy_view(rng)

    def _place(self, rest: Pose) -> None:
        self.world.reset()
        self.world.place(rest)


class RunnerFromAnywhere(ObjectRunner):
    """Grasps from any direction."""

    def __init__(
        self,
        engine: EngineName,
        world: World,
        grasps: pd.DataFrame,
        gripper: Gripper,
        *,
        noise: bool,
    ) -> None:
        """Set up with a world of the object and `egad.sim.free_hand`, and its labelled grasps."""
        self.engine, self.gripper, self.world = engine, gripper, world
        self._noise: NoiseName = "stereo" if noise else "none"
        self._runner = ClearingRunner(world, Clutter())
        self._labels = SceneLabels([grasps], world.models, gripper)

    @override
    def drop(self, rng: np.random.Generator) -> Pose | None:
        try:
            return make_scene(self.world, "single", rng)[0].pose
        except UnstableError:
            return None

    @override
    def labelled(self, rest: Pose) -> list[Grasp]:
        return list(islice(self._labels.possible([RestingObject(0, rest)]), MAX_PROPOSALS))

    @override
    def execute(self, rest: Pose, grasp: Grasp) -> Outcome:
        put(self.world, [RestingObject(0, rest)])
        return execute_pose(self.world, grasp.pose, grasp.width).outcome

    @override
    def _observe(self, rest: Pose, rng: np.random.Generator) -> Observation:
        cameras = camera_poses(SceneCameras(), rng)
        return self._runner.observe([RestingObject(0, rest)], self._noise, cameras, rng)


@contextmanager
def open_runner(
    engine: EngineName,
    model: Model,
    grasps: pd.DataFrame,
    gripper: Gripper,
    *,
    from_above: bool,
    depth_noise: float,
    contact: ContactRule | None = None,
) -> Iterator[ObjectRunner]:
    """A runner, for the duration of the `with` block.

    From any direction, any nonzero depth noise means 0.1 pixels, and the hand always closes where
    it was stopped, as in the protocol `egad`; from above, by default, a contact is a failure.
    """
    if from_above:
        arm = ARMS["axis"](gripper)
        with open_world(engine, [model], arm.robot) as world:
            rule = contact or ContactRule()
            trials = TrialProtocol(
                engine=engine,
                depth_noise=depth_noise,
                contact=rule.contact,
                stopping_force=rule.stopping_force,
            )
            yield RunnerFromAbove(TrialRunner(world, arm, trials), grasps)
        return
    with open_world(engine, [model], free_hand(gripper)) as world:
        yield RunnerFromAnywhere(engine, world, grasps, gripper, noise=depth_noise > 0)

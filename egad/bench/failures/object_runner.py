"""A table with one object to try grasps on: dropped, seen by a detector, and grasped."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from itertools import islice

import numpy as np
import pandas as pd

from egad.bench.clearing_runner import ClearingRunner
from egad.bench.failures.parameters import FailureParameters
from egad.bench.parameters import Clutter, ContactRule, TrialProtocol
from egad.bench.runner import Runner
from egad.bench.scene_labels import SceneLabels
from egad.bench.scenes import RestingObject
from egad.bench.trial_runner import TrialRunner
from egad.detectors import Detector, Failure, Grasp, Labels, NoiseName, ranked, try_to_plan
from egad.sim import ARMS, EngineName, Model, Pose, free_hand, open_world
from egad.tables.outcomes import Outcome

MIN_DOWN = np.cos(np.radians(10))  # of the approach of a grasp that is executed from above
MAX_PROPOSALS = 10


class ObjectRunner:
    """A table with one object; results depend only on arguments; `labelled`: ten grasps at most."""

    def __init__(
        self, engine: EngineName, runner: Runner, labelled: Callable[[Pose], list[Grasp]]
    ) -> None:
        """Wrap a runner, whose world has one object."""
        self.engine, self.world, self.gripper = engine, runner.world, runner.gripper
        self.labelled, self.drop, self._runner = labelled, runner.drop, runner

    def propose(
        self, detect: Detector, rest: Pose, rng: np.random.Generator
    ) -> list[Grasp] | Outcome | Failure:
        """At most ten executable grasps of a detector, best first; or why there is none."""
        return try_to_plan(
            lambda: ranked(self._runner.ask(detect, rest, rng), self.gripper, MAX_PROPOSALS)
        )

    def execute(self, rest: Pose, grasp: Grasp) -> Outcome:
        """Execute a grasp with a pose."""
        if isinstance(self._runner, TrialRunner):
            grasp = grasp.from_above(self.gripper)
        return self._runner.carry_out(rest, grasp).outcome or Outcome.FAILED

    def can_do(self, grasp: Grasp) -> bool:
        """Whether the hand can execute a grasp with a pose."""
        if isinstance(self._runner, TrialRunner) and -grasp.pose[2, 2] < MIN_DOWN:
            return False
        return grasp.infeasibility(self.gripper) is None


def _best_from_above(runner: TrialRunner, labels: Labels, rest: Pose) -> list[Grasp]:
    """Labelled grasps from above."""
    runner.place(rest)
    matrix = rest.matrix @ runner.world.model.to_principal
    found = labels.propose(matrix, runner.render_view(), runner.gripper)
    grasps = ranked(found, runner.gripper, MAX_PROPOSALS)
    return [] if isinstance(grasps, Outcome) else grasps


def _best(labels: SceneLabels, rest: Pose) -> list[Grasp]:
    """Labelled grasps in any direction."""
    return list(islice(labels.possible([RestingObject(0, rest)]), MAX_PROPOSALS))


@contextmanager
def open_runner(
    engine: EngineName,
    model: Model,
    grasps: pd.DataFrame,
    settings: FailureParameters,
    *,
    from_above: bool,
) -> Iterator[ObjectRunner]:
    """A runner; contacts are as in `egad`, any noise 0.1 pixels, unless grasps are from above."""
    gripper, depth_noise = settings.gripper, settings.failures.depth_noise
    if from_above:
        arm = ARMS["axis"](gripper)
        with open_world(engine, [model], arm.robot) as world:
            contact = {name: getattr(settings.trials, name) for name in ContactRule.model_fields}
            trials = TrialProtocol(engine=engine, depth_noise=depth_noise, **contact)
            runner = TrialRunner(world, arm, trials)
            yield ObjectRunner(engine, runner, partial(_best_from_above, runner, Labels(grasps)))
        return
    with open_world(engine, [model], free_hand(gripper)) as world:
        noise: NoiseName = "stereo" if depth_noise > 0 else "none"
        labels = SceneLabels([grasps], world.models, gripper)
        yield ObjectRunner(
            engine, ClearingRunner(world, Clutter(noise=(noise,))), partial(_best, labels)
        )

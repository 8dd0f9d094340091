"""Simulated grasping trials of a detector, from Python."""

import logging
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, Literal

import pandas as pd
import trimesh

from egad._util.display import Picture, draw, table_html
from egad._util.parameters import SCALE_RULES, from_arguments
from egad._util.progress import progress
from egad._util.workers import workers
from egad.detectors import (
    IN_ANY_DIRECTION,
    QUICK,
    SHIPPED_NETWORKS,
    Detector,
    DetectorConfig,
    FailureMonitor,
    Labels,
    check_gripper,
    check_views_will_do,
    make_detector,
    more_than_a_view,
    with_checked_answers,
)
from egad.errors import RejectedError, UserError, check_name
from egad.grasping import grasps_if_any
from egad.grasps import GraspLabel, label_parameters
from egad.grippers import Gripper, as_gripper
from egad.named_meshes import NamedMesh, named_meshes, simulated
from egad.objects import Dataset
from egad.outcomes import Outcome
from egad.sim import (
    CellErrors,
    EngineName,
    TrialParameters,
    TrialProtocol,
    check_engine,
    failed_attempts,
    run_attempts,
)
from egad.stats import Comparison, Mean, by_object, compare, engine_names, mean_rate, results

log = logging.getLogger(__name__)
LABELS = "labels"
BY_NAME = sorted({LABELS, *SHIPPED_NETWORKS, *QUICK} - set(IN_ANY_DIRECTION))


class Trials:
    """Attempts of a detector at objects.

    Attributes:
        table: One row per attempt; columns as in `results/README.md`, "trials".
    """

    def __init__(self, table: pd.DataFrame) -> None:
        """Wrap a table with the columns of `tables.evaluation.TRIALS`."""
        self.table = table.reset_index(drop=True)

    def __len__(self) -> int:
        return len(self.table)

    def __repr__(self) -> str:
        return f"Trials in {engine_names(self.table)}: {self.success_rate()}"

    def _repr_html_(self) -> str:
        """The success rate, and those of the objects, for notebooks."""
        rows = self.by_object()
        return table_html(repr(self), rows.assign(rate=rows["successes"] / rows["attempts"]))

    def plot(self) -> Picture:
        """Plot the outcomes of the attempts.

        Returns:
            Outcomes of all attempts, and of those at each object, for at most 30 objects with the
            lowest success rates; or, if all objects have labels of the evaluation set (A0 to G6),
            their success rates as a heat map. A notebook shows it; `save("trials.svg")` writes it.

        Raises:
            UserError: There are no attempts.
        """
        if not len(self):
            raise UserError("there are no attempts to plot")
        return draw("trial_charts", "trial_chart", self.table)

    def success_rate(self) -> Mean:
        """Successes over attempts, `value`, with its 95 % confidence `interval` over objects."""
        return mean_rate(self.table)

    def by_object(self) -> pd.DataFrame:
        """Successes and attempts of each object, by its label."""
        return by_object(self.table)

    def compare(self, other: "Trials") -> Comparison:
        """The difference to another detector over the attempts that both made.

        Raises:
            UserError: They have no attempt in common, or a label stands for two objects.
        """
        return compare(results(self.table, "first"), results(other.table, "second"))


def run_trials(
    detect: Detector | Callable[..., Any] | str,
    objects: Dataset | Mapping[str, trimesh.Trimesh],
    gripper: Gripper | str,
    attempts: int = 20,
    *,
    seed: int = 0,
    rule: str = "paper",
    reset: Literal["continue", "redrop"] = "continue",
    depth_noise: float = 0.0,
    errors: str | Mapping[str, Any] | CellErrors = "none",
    contact: Literal["collided", "close"] = "collided",
    stopping_force: float = 20.0,
    engine: EngineName = "mujoco",
    jobs: int = 1,
    keep_going: bool = False,
) -> Trials:
    """Let a detector grasp objects in simulation, as in EGAD, section V.

    Each object is scaled to the gripper and dropped onto a table. A depth camera looks down on it,
    the detector proposes grasps, and the best one is carried out: approach, close, lift, hold.
    All attempts at an object that cannot be simulated count as failed.

    An error of the detector counts as a failed attempt. Its traceback is in the column `failure`;
    that of the first error is also logged. An endless loop is not interrupted.

    Args:
        detect: A function or object that is called with `(view, gripper, rng)` and returns grasps
            (`egad.detectors.Detector`); or the name of a detector that needs no file:
            `antipodal-depth`, `random`, `ggcnn2-evolved` (a network that egad ships; it needs
            PyTorch), `ggcnn2-evolved-published` (the same, carried out as on the robot of EGAD);
            `suction-depth` for a suction cup; or `labels`, which knows where the object is and
            proposes the best of 100 grasps that are sampled with the seed.
        objects: A dataset, or meshes in metres by name.
        gripper: The gripper, or its name.
        attempts: Attempts at each object; 20 as in the paper.
        seed: The same seed gives the same drops, for all detectors.
        rule: How objects are scaled: see `egad.rescale`.
        reset: `continue`: after a success the hand drops the object from where it is; after a
            failure the object stays where it lies. `redrop`: every attempt begins with a new drop.
        depth_noise: Standard deviation of the disparity, pixels: about 0.1 for a RealSense D435.
            If it is not 0, the image also has holes beside edges and on steep surfaces.
        errors: Errors of a real cell: `none`, `typical`, or your own by their names, such as
            `{"calibration": 0.002}`; all of them: `trials.errors` in `config/README.md`.
        contact: What a contact on the way down means: `collided` is a failure; with `close` the
            fingers close where the hand was stopped, as on the robot of EGAD.
        stopping_force: Contact force that stops the hand on its way down, newtons.
        engine: What computes the physics: `mujoco` or `pybullet`.
        jobs: Number of processes; the result does not depend on it.
        keep_going: Whether to go on with a detector that fails in every attempt at the first three
            objects.

    Raises:
        UserError: The detector fails in every attempt at the first three objects, or at all if
            there are fewer. There is no such gripper, detector or rule, the detector is for jaws
            and the gripper has a suction cup or the other way round, the engine is not
            installed, a number is out of bounds, there are no objects, a mesh file of the dataset
            is missing, or the detector cannot be sent to other processes.

    Warns:
        UnitsWarning: The size of a mesh suggests a unit other than the metre.
        PartsWarning: An object needs more convex parts than are allowed.
    """
    hand = as_gripper(gripper)
    check_name("rule", rule, SCALE_RULES)
    check_engine(engine)
    trials = from_arguments(
        TrialProtocol,
        engine=engine,
        attempts=attempts,
        reset=reset,
        depth_noise=depth_noise,
        errors=errors,
        contact=contact,
        stopping_force=stopping_force,
        keep_going=keep_going,
    )
    parameters = from_arguments(TrialParameters, seed=seed, gripper=hand, trials=trials)
    targets = named_meshes(objects)
    if isinstance(detect, str):
        if detect in IN_ANY_DIRECTION:
            raise more_than_a_view(detect, "more")
        check_gripper(check_name("detector", detect, BY_NAME), hand)
    elif not callable(detect):
        raise UserError(f"a detector is a function or the name of one, got {detect!r}")
    else:
        check_views_will_do(detect)
    work = partial(_attempts, detect=detect, rule=rule, parameters=parameters)
    tables, monitor = [], FailureMonitor(len(targets), keep_going)
    with workers(jobs) as mapper:
        for table in progress(mapper(work, targets), "trying", len(targets)):
            monitor.check(table)
            tables.append(table)
    return Trials(pd.concat(tables))


def _attempts(
    target: NamedMesh,
    detect: Callable[..., Any] | str,
    rule: str,
    parameters: TrialParameters,
) -> pd.DataFrame:
    """All attempts at an object, columns of `tables.evaluation.TRIALS`."""
    try:
        mesh, model = simulated(target, parameters.gripper, rule)
    except RejectedError as reason:
        log.warning("%s cannot be simulated: %s", target.label, reason)
        return failed_attempts(target.label, target.id, parameters, Outcome.FAILED)
    ask = _detector(detect, mesh, target.id, parameters)
    return run_attempts(model, target.label, target.id, ask, parameters)


def _detector(
    detect: Callable[..., Any] | str, mesh: trimesh.Trimesh, name: str, parameters: TrialParameters
) -> Detector | Labels:
    """The detector that proposes grasps of an object.

    Args:
        detect: See `run_trials`.
        mesh: The object, scaled.
        name: Its id, which determines the grasps of `labels`.
        parameters: The gripper and the seed.
    """
    if not isinstance(detect, str):
        return with_checked_answers(detect)
    if detect != LABELS:
        return make_detector(DetectorConfig(detector=detect))
    wanted = label_parameters(parameters.gripper, GraspLabel().grasps, parameters.seed)
    return Labels(grasps_if_any(mesh, name, wanted))

"""Simulated grasping trials of a detector, from Python."""

from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from functools import partial
from typing import Any, Literal

import pandas as pd
import trimesh

from egad._util.display import Picture, draw, table_html
from egad._util.parameters import from_arguments
from egad._util.progress import progress
from egad._util.workers import workers
from egad.bench.attempts import failed_attempts, run_attempts
from egad.bench.parameters import CellErrors, TrialParameters, TrialProtocol, hand_of
from egad.bench.preparation import Labelled, labels_from, prepare_object
from egad.bench.stats import Comparison, Mean, by_object, compare, engine_names, mean_rate, results
from egad.detectors import (
    IN_ANY_DIRECTION,
    LABELS,
    QUICK,
    SHIPPED_NETWORKS,
    Detect,
    Detector,
    DetectorConfig,
    FailureMonitor,
    Labels,
    as_detector,
    check_gripper,
    check_views_will_do,
    knows_scene,
    more_than_a_view,
    opened,
)
from egad.errors import UserError
from egad.grasps import Grasps
from egad.grippers import Gripper
from egad.objects import Dataset, NamedMesh, named_meshes
from egad.sim import EngineName
from egad.tables.outcomes import Outcome

SAMPLED = 2000  # grasps of an object for `labels`: from above, a hand can use a quarter of them
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
    detect: Detect | str,
    objects: Dataset | Mapping[str, trimesh.Trimesh],
    gripper: Gripper | str,
    attempts: int = TrialProtocol().attempts,
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
    grasps: Mapping[str, Grasps] | None = None,
) -> Trials:
    """Let a detector grasp objects in simulation, as in EGAD, section V.

    Each object is scaled to the gripper and dropped onto a table. A depth camera looks down on it,
    the detector proposes grasps, and the best one is carried out: approach, close, lift, hold.
    All attempts at an object that cannot be simulated count as failed.

    An error of the detector counts as a failed attempt. Its traceback is in the column `failure`;
    that of the first error is also logged. An endless loop of a function is not interrupted.

    Args:
        detect: A function or object that is called with `(view, gripper, rng)` and returns grasps
            (`egad.detectors.Detector`); an `egad.detectors.DetectorConfig`, for example of a
            command; or the name of a detector that needs no file:
            `antipodal-depth`, `random`, `ggcnn2-evolved` (a network that egad ships; it needs
            PyTorch), `ggcnn2-evolved-published` (the same, carried out as on the robot of EGAD);
            `suction-depth` for a suction cup; or `labels`, which knows where the object is and
            proposes the best of 2000 grasps that are sampled with the seed.
        objects: A dataset, or meshes in metres by name.
        gripper: The gripper, or its name.
        attempts: Attempts at each object: 10, as in the settings; the paper made 20.
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
        engine: What computes the physics: `mujoco`, `pybullet` or `drake`.
        jobs: Number of processes; the result does not depend on it.
        keep_going: Whether to go on with a detector that fails in every attempt at the first three
            objects.
        grasps: For `labels`: grasps of each object by name, in place of sampled ones, such as those
            of `egad.read_grasps` with the mesh; with the rule `none`.

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
    hand = hand_of(gripper, rule, engine)
    trials = from_arguments(
        TrialProtocol,
        engine=engine,
        attempts=attempts,
        reset=reset,
        depth_noise=depth_noise,
        errors=errors,
        contact=contact,
        stopping_force=stopping_force,
    )
    parameters = from_arguments(TrialParameters, seed=seed, gripper=hand, trials=trials)
    if isinstance(detect, str) and detect in IN_ANY_DIRECTION:
        raise more_than_a_view(detect, "more")
    known = as_detector(detect, BY_NAME)
    targets = named_meshes(objects)
    labelled = labels_from(grasps, known, rule, targets)
    return try_objects(known, targets, parameters, rule, jobs, keep_going, labelled)


def try_objects(
    detect: Detect,
    targets: Sequence[NamedMesh],
    parameters: TrialParameters,
    rule: str,
    jobs: int = 1,
    keep_going: bool = False,
    grasps: Mapping[str, pd.DataFrame] | None = None,
) -> Trials:
    """Let a detector grasp objects, `labels` perhaps with `grasps` by id; see `run_trials`."""
    if not isinstance(detect, DetectorConfig):
        check_views_will_do(detect)
    elif detect.detector in IN_ANY_DIRECTION:
        raise more_than_a_view(detect.name, "more")
    else:
        check_gripper(detect.name, parameters.gripper)
    asked = (
        nullcontext()
        if knows_scene(detect)
        else opened(detect, parameters.planning_time, at_once=False)
    )
    tables, monitor = [], FailureMonitor(len(targets), keep_going)
    with asked as ask, workers(jobs) as mapper:
        labelled = None if ask else grasps or parameters.seed
        work = partial(_attempts, ask=ask, rule=rule, parameters=parameters, labelled=labelled)
        for table in progress(mapper(work, targets), "trying", len(targets)):
            monitor.check(table)
            tables.append(table)
    return Trials(pd.concat(tables))


def _attempts(
    target: NamedMesh,
    ask: Detector | None,
    rule: str,
    parameters: TrialParameters,
    labelled: Labelled,
) -> pd.DataFrame:
    """All attempts at an object, columns of `tables.evaluation.TRIALS`; no detector: `labels`."""
    known = prepare_object(target, parameters.gripper, rule, labelled, grasps=SAMPLED)
    if known is None:
        return failed_attempts(target.label, target.id, parameters, Outcome.FAILED)
    detect = ask or Labels(known.grasps)
    return run_attempts(known.model, target.label, target.id, detect, parameters)

"""Labelled grasps executed on a floating object, to check whether their qualities are right.

A label accounts for neither gravity nor a table, and its approach can come from any side. So the
object is turned until the labelled approach points down, held in the air until the hand has
arrived, and weightless until the fingers have closed. Then it is lifted as in every trial. The pads
have the friction that the labels assume. (ACRONYM also closes in free space, and then shakes;
Eppner 2021.)
"""

from typing import Any

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

from egad._util.arrays import Floats
from egad.detectors import Grasp
from egad.grasps import hand_poses
from egad.grippers import Gripper, check_jaws, finger_span
from egad.random import generator
from egad.sim.arms import ARMS
from egad.sim.engines import open_world
from egad.sim.execution import Execution, execute
from egad.sim.model import Model
from egad.sim.parameters import LabelTrialParameters
from egad.sim.world import Pose
from egad.tables import parquet
from egad.tables.columns import vector_names
from egad.tables.evaluation import AGREEMENT
from egad.tables.outcomes import Outcome

CLEAR = 0.1  # metres of air below the object at least
RATINGS = ("quality", "robust_quality", "robust_success_rate")


def sample_labelled_grasps(
    grasps: pd.DataFrame, object_id: str, count: int, seed: int
) -> pd.DataFrame:
    """A sample of at most `count` reachable `GRASPS`, in their order, with the numbers before."""
    free = grasps[grasps["collision_free"]]
    rng = generator(seed, "agreement", object_id)
    chosen = np.sort(rng.permutation(len(free))[:count])
    return free.iloc[chosen].assign(n_labelled=len(grasps), n_collision_free=len(free))


def execute_labelled_grasps(
    model: Model, label: str, object_id: str, sample: pd.DataFrame, settings: LabelTrialParameters
) -> pd.DataFrame:
    """Execute a sample of labelled grasps, each by itself: rows of `AGREEMENT`."""
    check_jaws(settings.gripper, "a labelled grasp of a floating object")
    found = []
    gripper = settings.gripper.model_copy(update={"friction": settings.quality.friction})
    arm = ARMS[settings.trials.arm](gripper)
    with open_world(settings.trials.engine, [model], arm.robot) as world:
        for row in parquet.records(sample):
            pose, grasp = floating_pose(model, row, gripper)
            world.reset()
            world.place(pose)
            contact = float(row["width"])
            found.append(execute(world, arm, settings.trials, grasp, afloat=True, contact=contact))
    return _table(label, object_id, sample, found, settings)


def failed_labelled_grasps(
    label: str,
    object_id: str,
    sample: pd.DataFrame,
    settings: LabelTrialParameters,
    outcome: Outcome,
) -> pd.DataFrame:
    """The same table of an object that cannot be simulated: all grasps have the same outcome."""
    found = [Execution(outcome, 0.0, None)] * len(sample)
    return _table(label, object_id, sample, found, settings)


def floating_pose(model: Model, row: dict[str, Any], gripper: Gripper) -> tuple[Pose, Grasp]:
    """The pose that turns a labelled grasp into one from above, closing along x; that grasp."""
    center, axis, approach = (
        np.array([[row[name] for name in vector_names(part)]])
        for part in ("center", "axis", "approach")
    )
    from_object = np.linalg.inv(hand_poses(center, axis, approach)[0])
    return float_before_hand(
        from_object @ np.linalg.inv(model.to_principal), float(model.mesh.scale), gripper
    )


def float_before_hand(to_hand: Floats, size: float, gripper: Gripper) -> tuple[Pose, Grasp]:
    """The same for a hand at `to_hand`, (4, 4); the object is `size` long and floats above it."""
    height = size + CLEAR
    above = hand_poses(
        np.array([[0.0, 0.0, height]]), np.array([[1.0, 0.0, 0.0]]), np.array([[0.0, 0.0, -1.0]])
    )
    matrix = above[0] @ to_hand
    depth = finger_span(gripper)[1]
    return (
        Pose(matrix[:3, 3], Rotation.from_matrix(matrix[:3, :3]).as_quat()),
        Grasp((0.0, 0.0, height), 0.0, gripper.opening, depth, quality=1.0),
    )


def _table(
    label: str,
    object_id: str,
    sample: pd.DataFrame,
    found: list[Execution],
    settings: LabelTrialParameters,
) -> pd.DataFrame:
    known = sample[["grasp", *RATINGS, "n_labelled", "n_collision_free"]].reset_index(drop=True)
    table = known.assign(
        label=label,
        id=object_id,
        outcome=[each.outcome.value for each in found],
        success=[each.outcome == Outcome.SUCCESS for each in found],
        lifted=[each.lifted for each in found],
        engine=settings.trials.engine,
    )
    return table.loc[:, list(AGREEMENT.names)]

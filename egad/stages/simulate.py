"""simulate: trials of a grasp detector on the evaluation objects of a shard."""

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pandas as pd

from egad.errors import UserError
from egad.exchange.meshes import read_mesh
from egad.progress import progress
from egad.stage_settings import SimulatedTrials
from egad.stages.shards import rows_in_shard
from egad.tables import parquet
from egad.tables.evaluation import EVAL49, TRIALS
from egad.tables.grasping import GRASPS
from egad.trials.child import Child
from egad.trials.labelled import Labels
from egad.trials.policies import QUICK, Detector
from egad.trials.protocol import run as run_trials

log = logging.getLogger(__name__)


def run(
    settings: SimulatedTrials,
    evaluation: Path,
    meshes: Path,
    grasps: Path | None,
    shard: tuple[int, int],
    out: Path,
) -> None:
    """Try to grasp each object of a shard.

    Args:
        settings: What this stage reads.
        evaluation: Table with the columns of `tables.evaluation.EVAL49`.
        meshes: Folder of the meshes, scaled to the gripper.
        grasps: Labelled grasps of the objects, for the detector `labels`.
        shard: Number of the shard, and of how many.
        out: Table with the columns of `tables.evaluation.TRIALS`.
    """
    chosen = parquet.read(evaluation, EVAL49)
    chosen = rows_in_shard(chosen, *shard)
    parts = []
    with opened(settings, grasps) as detector_of:
        for row in progress(parquet.records(chosen), "trying", len(chosen)):
            mesh = read_mesh(meshes / f"{row['object_label']}.obj", "m")
            detect = detector_of(row["id"])
            parts.append(run_trials(mesh, row["label"], row["id"], detect, settings))
    table = pd.concat(parts) if parts else parquet.empty(TRIALS)
    parquet.write(table, TRIALS, out)
    log.info("%d attempts, %d successes", len(table), int(table["success"].sum()))


@contextmanager
def opened(
    settings: SimulatedTrials, grasps: Path | None
) -> Iterator[Callable[[str], Detector | Labels]]:
    """The detector for each object, by its id; for as long as the block lasts.

    Raises:
        UserError: It cannot be found or made.
    """
    policy = settings.policy
    if policy.detector == "labels":
        yield _labels(grasps)
    elif policy.detector in QUICK:
        yield lambda _: QUICK[policy.detector]
    else:
        with Child(policy, settings.trials.planning_time) as child:
            yield lambda _: child


def _labels(grasps: Path | None) -> Callable[[str], Labels]:
    if grasps is None:
        raise UserError("the detector labels needs --grasps, the table of labelled grasps")
    table = parquet.read(grasps, GRASPS)
    return lambda object_id: Labels(table[table["id"] == object_id])

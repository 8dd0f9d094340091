"""simulate: trials of a grasp detector on the evaluation objects of a shard."""

import logging
from pathlib import Path

import pandas as pd

from egad.exchange.meshes import read_mesh
from egad.progress import progress
from egad.stage_settings import SimulatedTrials
from egad.stages.shards import rows_in_shard
from egad.tables import parquet
from egad.tables.evaluation import EVAL49, TRIALS
from egad.trials.protocol import run as run_trials

log = logging.getLogger(__name__)


def run(
    settings: SimulatedTrials,
    policy: str,
    evaluation: Path,
    meshes: Path,
    shard: tuple[int, int],
    out: Path,
) -> None:
    """Try to grasp each object of a shard.

    Args:
        settings: What this stage reads.
        policy: Name of the grasp detector.
        evaluation: Table with the columns of `tables.evaluation.EVAL49`.
        meshes: Folder of the meshes, scaled to the gripper.
        shard: Number of the shard, and of how many.
        out: Table with the columns of `tables.evaluation.TRIALS`.
    """
    chosen = parquet.read(evaluation, EVAL49)
    chosen = rows_in_shard(chosen, *shard)
    parts = []
    for row in progress(parquet.records(chosen), "trying", len(chosen)):
        mesh = read_mesh(meshes / f"{row['object_label']}.obj", "m")
        parts.append(run_trials(mesh, row["label"], row["id"], policy, settings))
    table = pd.concat(parts) if parts else parquet.empty(TRIALS)
    parquet.write(table, TRIALS, out)
    log.info("%d attempts, %d successes", len(table), int(table["success"].sum()))

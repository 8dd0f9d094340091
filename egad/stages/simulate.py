"""simulate: trials of a grasp detector on the evaluation objects of a shard."""

import logging
from pathlib import Path

import pandas as pd

from egad import tables
from egad.exchange.meshes import read_mesh
from egad.progress import progress
from egad.stage_settings import SimulatedTrials
from egad.stages.shards import rows_in_shard
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
        evaluation: Table with the columns of `egad.tables.EVAL49`.
        meshes: Folder of the meshes, scaled to the gripper.
        shard: Number of the shard, and of how many.
        out: Table with the columns of `egad.tables.TRIALS`.
    """
    chosen = tables.read(evaluation, tables.EVAL49)
    chosen = rows_in_shard(chosen, *shard)
    parts = []
    for row in progress(tables.records(chosen), "trying", len(chosen)):
        mesh = read_mesh(meshes / f"{row['object_label']}.obj", "m")
        parts.append(run_trials(mesh, row["label"], row["id"], policy, settings))
    table = pd.concat(parts) if parts else tables.empty(tables.TRIALS)
    tables.write(table, tables.TRIALS, out)
    log.info("%d attempts, %d successes", len(table), int(table["success"].sum()))

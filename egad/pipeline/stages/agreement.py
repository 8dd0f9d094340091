"""agreement: labelled grasps of the evaluation objects of a shard, carried out."""

import logging
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd

from egad._util.child_process import Survivor
from egad._util.progress import phase, progress
from egad.pipeline.stages.bundled import ENGINE_TIME, model_in, outlived, rows_by_id
from egad.pipeline.stages.shards import rows_in_shard
from egad.sim.labelled_trials import carried_out, not_carried_out, sampled, shares
from egad.sim.parameters import LabelTrialParameters
from egad.tables import parquet
from egad.tables.evaluation import AGREEMENT, EVAL49
from egad.tables.grasping import GRASPS

log = logging.getLogger(__name__)
Task = tuple[Mapping[str, Any], pd.DataFrame]


def run(
    settings: LabelTrialParameters,
    evaluation: Path,
    bundle: Path,
    grasps: Path,
    shard: tuple[int, int],
    out: Path,
) -> None:
    """Carry out a sample of the labelled grasps of each object of a shard.

    As in `simulate`, all is done in one process apart from this one; grasps of an object that ends
    it twice are marked as crashed.

    Args:
        settings: What this stage reads.
        evaluation: Table with the columns of `tables.evaluation.EVAL49`.
        bundle: Folder of the simulation bundle, scaled to the gripper. Grasps of an object that is
            not in it have failed.
        grasps: Labelled grasps for the gripper, columns of `tables.grasping.GRASPS`.
        shard: Number of the shard, and of how many.
        out: Table with the columns of `tables.evaluation.AGREEMENT`.
    """
    objects = parquet.read(evaluation, EVAL49)
    share = dict(zip(objects["id"], shares(settings.agreement.grasps, len(objects)), strict=True))
    chosen = parquet.records(rows_in_shard(objects, *shard))
    labelled = parquet.read(grasps, GRASPS)
    known = rows_by_id(bundle)
    parts = []
    limit = ENGINE_TIME * max(share.values(), default=1)
    phase("starting the simulator")
    with Survivor(partial(executor, settings, bundle), limit) as execute:
        for row in progress(chosen, "trying", len(chosen)):
            label, name = row["label"], row["id"]
            sample = sampled(labelled[labelled["id"] == name], name, share[name], settings.seed)
            task = (known[name], sample) if name in known else None
            failed = partial(not_carried_out, label, name, sample)
            parts.append(outlived(row, execute, task, failed))
    filled = [table for table in parts if len(table)]
    whole = pd.concat(filled) if filled else parquet.empty(AGREEMENT)
    parquet.write(whole, AGREEMENT, out)
    log.info("%d grasps, %d successes", len(whole), int(whole["success"].sum()))


@contextmanager
def executor(
    settings: LabelTrialParameters, bundle: Path
) -> Iterator[Callable[[Task], pd.DataFrame]]:
    """What carries out grasps at an object of the bundle: its row there, and the grasps."""

    def carry_out(task: Task) -> pd.DataFrame:
        row, sample = task
        model = model_in(bundle, row)
        return carried_out(model, row["label"], row["id"], sample, settings)

    yield carry_out

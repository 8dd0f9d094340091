"""agreement: execute labelled grasps of the evaluation objects of a shard in simulation."""

import logging
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd

from egad._util.progress import phase, progress
from egad.bench import ENGINE_TIME, run_or_replace
from egad.exchange import model_in, rows_by_id
from egad.learning.images import evenly
from egad.sim import (
    LabelTrialParameters,
    execute_labelled_grasps,
    failed_labelled_grasps,
    sample_labelled_grasps,
)
from egad.tables import parquet
from egad.tables.evaluation import AGREEMENT, EVAL49
from egad.tables.grasping import GRASPS
from egad_workflow.job import run_job
from egad_workflow.restarting_worker import RestartingWorker
from egad_workflow.shards import rows_in_shard

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
    """Execute labelled grasps of the evaluation objects of a shard in simulation."""
    objects = parquet.read(evaluation, EVAL49)
    share = dict(zip(objects["id"], evenly(settings.agreement.grasps, len(objects)), strict=True))
    chosen = parquet.records(rows_in_shard(objects, *shard))
    labelled = parquet.read(grasps, GRASPS)
    known = rows_by_id(bundle)
    parts = []
    limit = ENGINE_TIME * max(share.values(), default=1)
    phase("starting the simulator")
    with RestartingWorker(partial(open_agreement, settings, bundle), limit) as execute:
        for row in progress(chosen, "trying", len(chosen)):
            label, name = row["label"], row["id"]
            sample = sample_labelled_grasps(
                labelled[labelled["id"] == name], name, share[name], settings.seed
            )
            task = (known[name], sample) if name in known else None
            failed = partial(failed_labelled_grasps, label, name, sample, settings)
            parts.append(run_or_replace(row, execute, task, failed))
    filled = [table for table in parts if len(table)]
    whole = pd.concat(filled) if filled else parquet.empty(AGREEMENT)
    parquet.write(whole, AGREEMENT, out)
    log.info("%d grasps, %d successes", len(whole), int(whole["success"].sum()))


@contextmanager
def open_agreement(
    settings: LabelTrialParameters, bundle: Path
) -> Iterator[Callable[[Task], pd.DataFrame]]:
    """A function that executes grasps of an object, given its row in the bundle and the grasps."""

    def execute(task: Task) -> pd.DataFrame:
        row, sample = task
        model = model_in(bundle, row)
        return execute_labelled_grasps(model, row["label"], row["id"], sample, settings)

    yield execute


if __name__ == "__main__":
    run_job(run)

"""simulate: trials of a grasp detector on the evaluation objects of a shard."""

import logging
from functools import partial
from pathlib import Path

import pandas as pd

from egad._util.child_process import RestartingWorker
from egad._util.progress import phase, progress
from egad.bench import failed_attempts
from egad.config.stages import SimulatedTrials
from egad.detectors import FailureMonitor, keep_failure
from egad.tables import parquet
from egad.tables.evaluation import EVAL49, TRIALS
from egad.workflow.bundled import ENGINE_TIME, rows_by_id, run_or_replace
from egad.workflow.job import run_job
from egad.workflow.shards import rows_in_shard
from egad.workflow.simulations import open_trials

log = logging.getLogger(__name__)


def run(
    settings: SimulatedTrials,
    evaluation: Path,
    bundle: Path,
    shard: tuple[int, int],
    out: Path,
    grasps: Path | None = None,
    keep_going: bool = False,
) -> None:
    """Run simulated grasping trials on the evaluation objects of a shard.

    Everything runs in a separate process, which is restarted if the engine crashes or hangs. If
    that happens twice with an object, it is marked as crashed. All attempts of an object that the
    bundle does not contain fail.
    """
    chosen = rows_in_shard(parquet.read(evaluation, EVAL49), *shard)
    known = rows_by_id(bundle)
    parts = []
    limit = settings.trials.attempts * (settings.trials.planning_time + ENGINE_TIME)
    phase("starting the simulator")
    monitor = FailureMonitor(len(chosen), keep_going)
    with (
        keep_failure(out),
        RestartingWorker(partial(open_trials, settings, bundle, grasps), limit) as attempt,
    ):
        for row in progress(parquet.records(chosen), "trying", len(chosen)):
            failed = partial(failed_attempts, row["label"], row["id"], settings)
            parts.append(run_or_replace(row, attempt, known.get(row["id"]), failed))
            monitor.check(parts[-1])
    whole = pd.concat(parts) if parts else parquet.empty(TRIALS)
    parquet.write(whole, TRIALS, out)
    log.info("%d attempts, %d successes", len(whole), int(whole["success"].sum()))


if __name__ == "__main__":
    run_job(run)

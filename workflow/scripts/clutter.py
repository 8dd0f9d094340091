"""clutter: a shard of rounds of clearing a table with a grasp detector."""

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache, partial
from pathlib import Path

import pandas as pd

from egad._util.progress import phase, progress
from egad.bench import ENGINE_TIME, ClearedTables, Round, failed_round, rounds_of
from egad.bench.clearing import Cleared, open_table
from egad.detectors import STARTING_TIME, FailureMonitor, keep_failure, knows_scene
from egad.exchange import labels_in_bundle, model_in, rows_by_id
from egad.tables import parquet
from egad.tables.clutter import CLUTTER
from egad.tables.grasping import GRASPS
from egad.tables.outcomes import Outcome
from egad_workflow.job import run_job
from egad_workflow.restarting_worker import RestartingWorker

log = logging.getLogger(__name__)


def run(
    settings: ClearedTables,
    bundle: Path,
    shard: tuple[int, int],
    out: Path,
    grasps: Path | None = None,
    keep_going: bool = False,
) -> None:
    """Let a grasp detector clear tables of several objects of the evaluation set."""
    number, shards = shard
    todo = rounds_of(list(rows_by_id(bundle)), settings)[number::shards]
    tables = [parquet.empty(CLUTTER)]
    phase("starting the simulator")
    attempt = settings.planning_time + STARTING_TIME + ENGINE_TIME
    monitor = FailureMonitor(len(todo), keep_going, "rounds")
    limit = 2 * settings.clutter.objects * attempt
    with (
        keep_failure(out),
        RestartingWorker(partial(open_clutter, settings, bundle, grasps), limit) as clear,
    ):
        for this in progress(todo, "clearing", len(todo)):
            done: Cleared | None = clear(this)
            if done is None:
                log.warning("round %d, %s: %s", this.number, this.scene, Outcome.CRASHED)
            table, _ = done or (failed_round(this, settings, Outcome.CRASHED), [])
            tables.append(table)
            monitor.check(table)
    whole = pd.concat([table for table in tables if len(table)] or tables)
    parquet.write(whole, CLUTTER, out)
    log.info("%d attempts, %d successes", len(whole), int(whole["success"].sum()))


@contextmanager
def open_clutter(
    settings: ClearedTables, bundle: Path, grasps: Path | None
) -> Iterator[Callable[[Round], Cleared]]:
    """A function that lets the detector clear one table of objects of a bundle."""
    known = rows_by_id(bundle)
    detector, none = settings.detector, parquet.empty(GRASPS)
    knows = knows_scene(detector)
    labels = labels_in_bundle(detector, settings.gripper, bundle, grasps) if knows else {}
    model = cache(lambda name: model_in(bundle, known[name]))
    with open_table(detector, model, lambda name: labels.get(name, none), settings) as clear:
        yield clear


if __name__ == "__main__":
    run_job(run)

"""simulate: trials of a grasp detector on the evaluation objects of a shard."""

import logging
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd

from egad._util.progress import phase, progress
from egad.bench import ENGINE_TIME, SimulatedTrials, failed_attempts, run_attempts, run_or_replace
from egad.detectors import (
    IN_SCENES,
    Detector,
    FailureMonitor,
    Labels,
    check_views_will_do,
    keep_failure,
    knows_scene,
    opened,
)
from egad.exchange import labels_in_bundle, model_in, rows_by_id
from egad.tables import parquet
from egad.tables.evaluation import EVAL49, TRIALS
from egad.tables.grasping import GRASPS
from egad_workflow.job import run_job
from egad_workflow.restarting_worker import RestartingWorker
from egad_workflow.shards import rows_in_shard

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
    """Run trials on the evaluation objects of a shard; those not in the bundle fail."""
    chosen = rows_in_shard(parquet.read(evaluation, EVAL49), *shard)
    known = rows_by_id(bundle)
    parts = []
    limit = settings.trials.attempts * (settings.planning_time + ENGINE_TIME)
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


@contextmanager
def open_trials(
    settings: SimulatedTrials, bundle: Path, grasps: Path | None
) -> Iterator[Callable[[Mapping[str, Any]], pd.DataFrame]]:
    """A function that runs all attempts of an object, given its row in the bundle."""
    with open_detector(settings, bundle, grasps) as detector_of:

        def attempts(row: Mapping[str, Any]) -> pd.DataFrame:
            detect = detector_of(row["id"])
            return run_attempts(model_in(bundle, row), row["label"], row["id"], detect, settings)

        yield attempts


@contextmanager
def open_detector(
    settings: SimulatedTrials, bundle: Path, grasps: Path | None
) -> Iterator[Callable[[str], Detector | Labels]]:
    """A function that returns the detector of an object by its id, valid within the context."""
    config, none = settings.detector, parquet.empty(GRASPS)
    if knows_scene(config):
        labels = labels_in_bundle(config, settings.gripper, bundle, grasps)
        yield lambda object_id: Labels(labels.get(object_id, none))
        return
    if config.detector in IN_SCENES:
        check_views_will_do(IN_SCENES[config.detector])
    with opened(config, settings.planning_time) as detect:
        yield lambda _: detect


if __name__ == "__main__":
    run_job(run)

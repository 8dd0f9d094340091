"""simulate: trials of a grasp detector on the evaluation objects of a shard."""

import logging
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import pandas as pd

from egad._util.child_process import Survivor
from egad._util.progress import phase, progress
from egad.detectors import (
    IN_SCENES,
    Detector,
    DetectorConfig,
    FailureMonitor,
    Labels,
    check_views_will_do,
    keep_failure,
    opened,
)
from egad.errors import UserError
from egad.pipeline.parameters import Evaluation, Input, Output, Shard, command
from egad.pipeline.stages.bundled import ENGINE_TIME, model_in, outlived, rows_by_id
from egad.pipeline.stages.shards import rows_in_shard
from egad.sim import TrialParameters, failed_attempts, run_attempts
from egad.tables import parquet
from egad.tables.evaluation import EVAL49, TRIALS
from egad.tables.grasping import GRASPS

log = logging.getLogger(__name__)


class SimulatedTrials(TrialParameters):
    """Simulated trials of a grasp detector."""

    detector: DetectorConfig


@command()
def run(
    settings: SimulatedTrials,
    evaluation: Evaluation,
    bundle: Annotated[Path, Input()],
    shard: Shard,
    out: Annotated[Path, Output("D/trials/G/P.parquet", TRIALS)],
    grasps: Annotated[Path | None, Input()] = None,
) -> None:
    """Run simulated grasping trials on the evaluation objects of a shard.

    Everything runs in a separate process, which is restarted if the engine crashes or hangs. An
    object with which that happens twice is marked as crashed.

    Args:
        settings: Settings of this stage.
        evaluation: Evaluation set.
        bundle: Folder of the simulation bundle, scaled to the gripper. All attempts of an object
            that it does not contain fail.
        shard: Number of this shard, and number of shards.
        out: Simulated trials of detector P with gripper G, one attempt per row.
        grasps: Labelled grasps of the objects, for the detector `labels`.
    """
    chosen = rows_in_shard(parquet.read(evaluation, EVAL49), *shard)
    known = rows_by_id(bundle)
    parts = []
    limit = settings.trials.attempts * (settings.trials.planning_time + ENGINE_TIME)
    phase("starting the simulator")
    monitor = FailureMonitor(len(chosen), settings.trials.keep_going)
    with (
        keep_failure(out),
        Survivor(partial(open_runner, settings, bundle, grasps), limit) as attempt,
    ):
        for row in progress(parquet.records(chosen), "trying", len(chosen)):
            failed = partial(failed_attempts, row["label"], row["id"], settings)
            parts.append(outlived(row, attempt, known.get(row["id"]), failed))
            monitor.check(parts[-1])
    whole = pd.concat(parts) if parts else parquet.empty(TRIALS)
    parquet.write(whole, TRIALS, out)
    log.info("%d attempts, %d successes", len(whole), int(whole["success"].sum()))


@contextmanager
def open_runner(
    settings: SimulatedTrials, bundle: Path, grasps: Path | None
) -> Iterator[Callable[[Mapping[str, Any]], pd.DataFrame]]:
    """A function that runs all attempts of an object, given its row in the bundle."""
    with open_detector(settings, grasps) as detector_of:

        def attempts(row: Mapping[str, Any]) -> pd.DataFrame:
            detect = detector_of(row["id"])
            return run_attempts(model_in(bundle, row), row["label"], row["id"], detect, settings)

        yield attempts


@contextmanager
def open_detector(
    settings: SimulatedTrials, grasps: Path | None
) -> Iterator[Callable[[str], Detector | Labels]]:
    """A function that returns the detector of an object by its id, valid within the context.

    Raises:
        UserError: The detector cannot be found or created.
    """
    config = settings.detector
    if config.detector == "labels":
        yield _labels(grasps)
        return
    if config.detector in IN_SCENES:
        check_views_will_do(IN_SCENES[config.detector])
    with opened(config, settings.trials.planning_time) as detect:
        yield lambda _: detect


def _labels(grasps: Path | None) -> Callable[[str], Labels]:
    if grasps is None:
        raise UserError("the detector labels needs --grasps, the table of labelled grasps")
    table = parquet.read(grasps, GRASPS)
    return lambda object_id: Labels(table[table["id"] == object_id])

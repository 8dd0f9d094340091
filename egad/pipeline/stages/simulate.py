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
from egad.detectors.base import Detector
from egad.detectors.labels import Labels
from egad.detectors.parameters import DetectorConfig
from egad.detectors.registry import QUICK
from egad.detectors.subprocess import Child
from egad.errors import UserError
from egad.pipeline.parameters import Evaluation, Input, Output, Shard, command
from egad.pipeline.stages.bundled import ENGINE_TIME, model_in, outlived, rows_by_id
from egad.pipeline.stages.shards import rows_in_shard
from egad.sim.parameters import TrialParameters
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
    """Try to grasp the evaluation objects of a shard in simulation.

    All is done in one process, apart from this one: if the engine ends it or hangs, it is started
    anew, and an object with which that happens twice is marked as crashed.

    Args:
        settings: What this stage reads.
        evaluation: Evaluation set.
        bundle: Folder of the simulation bundle, scaled to the gripper. An object that is not in it
            has failed attempts only.
        shard: Number of the shard, and of how many.
        out: Simulated trials of detector P with gripper G, one attempt a row.
        grasps: Labelled grasps of the objects, for the detector `labels`.
    """
    from egad.sim.attempts import failed_attempts  # noqa: PLC0415 (PyBullet greets on stderr)

    chosen = rows_in_shard(parquet.read(evaluation, EVAL49), *shard)
    known = rows_by_id(bundle)
    parts = []
    limit = settings.trials.attempts * (settings.trials.planning_time + ENGINE_TIME)
    phase("starting the simulator")
    with Survivor(partial(open_runner, settings, bundle, grasps), limit) as attempt:
        for row in progress(parquet.records(chosen), "trying", len(chosen)):
            failed = partial(failed_attempts, row["label"], row["id"], settings)
            parts.append(outlived(row, attempt, known.get(row["id"]), failed))
    whole = pd.concat(parts) if parts else parquet.empty(TRIALS)
    parquet.write(whole, TRIALS, out)
    log.info("%d attempts, %d successes", len(whole), int(whole["success"].sum()))


@contextmanager
def open_runner(
    settings: SimulatedTrials, bundle: Path, grasps: Path | None
) -> Iterator[Callable[[Mapping[str, Any]], pd.DataFrame]]:
    """What makes all attempts at an object of the bundle, by its row there."""
    from egad.sim.attempts import run_attempts  # noqa: PLC0415

    with open_detector(settings, grasps) as detector_of:

        def attempts(row: Mapping[str, Any]) -> pd.DataFrame:
            detect = detector_of(row["id"])
            return run_attempts(model_in(bundle, row), row["label"], row["id"], detect, settings)

        yield attempts


@contextmanager
def open_detector(
    settings: SimulatedTrials, grasps: Path | None
) -> Iterator[Callable[[str], Detector | Labels]]:
    """The detector for each object, by its id; for as long as the block lasts.

    Raises:
        UserError: It cannot be found or made.
    """
    config = settings.detector
    if config.detector == "labels":
        yield _labels(grasps)
    elif config.detector in QUICK:
        yield lambda _: QUICK[config.detector]
    else:
        with Child(config, settings.trials.planning_time) as child:
            yield lambda _: child


def _labels(grasps: Path | None) -> Callable[[str], Labels]:
    if grasps is None:
        raise UserError("the detector labels needs --grasps, the table of labelled grasps")
    table = parquet.read(grasps, GRASPS)
    return lambda object_id: Labels(table[table["id"] == object_id])

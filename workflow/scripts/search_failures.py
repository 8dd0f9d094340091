"""search_failures: objects that can be grasped, but that a detector does not grasp; one shard."""

import logging
from pathlib import Path

import numpy as np

from egad._util.progress import phase, shared_progress
from egad.bench.failures import DetectorFailures, ObjectVerdict, attempts_of, run_shard
from egad.detectors import keep_failure
from egad.tables import parquet
from egad.tables.evolution import ARCHIVE
from egad.tables.failures import EXAMINED, FAILURE_ATTEMPTS
from egad_workflow.archive_settings import MEASURING, check_provenance, differences
from egad_workflow.job import run_job

log = logging.getLogger(__name__)


def run(
    settings: DetectorFailures, archive: Path, shard: int, examined: Path, attempts: Path
) -> None:
    """Search a shard of an archive for failures of a grasp detector."""
    check_provenance(archive, settings.breeding, ("shape",))
    objects = parquet.read(archive, ARCHIVE)
    if other := differences(archive, settings.breeding, MEASURING):
        log.info("\n".join(["The objects are measured again, as settings differ:", *other]))
        objects["graspability"] = np.nan
    phase("starting the simulator")
    with (
        keep_failure(examined),
        shared_progress("attempts", attempts_of(shard, settings.failures)) as done,
    ):
        found = run_shard(shard, objects, settings.detector, settings, done=done)
    parquet.write(found.examined, EXAMINED, examined)
    parquet.write(found.attempts, FAILURE_ATTEMPTS, attempts)
    failures = int((found.examined["verdict"] == ObjectVerdict.FAILURE).sum())
    log.info(
        "%d attempts, %d failures among %d objects",
        len(found.attempts),
        failures,
        len(found.examined),
    )


if __name__ == "__main__":
    run_job(run)

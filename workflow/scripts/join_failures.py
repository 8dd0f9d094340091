"""join_failures: the failures found by all shards of a search, in one archive."""

import logging
from pathlib import Path

from egad.bench.failures import DetectorFailures, Found, join
from egad.tables import parquet
from egad.tables.failures import EXAMINED, FAILURE_ATTEMPTS
from egad_workflow.job import run_job

log = logging.getLogger(__name__)


def run(
    settings: DetectorFailures,
    examined: list[Path],
    attempts: list[Path],
    failures: Path,
    jobs: int,
) -> None:
    """Join the failures of a grasp detector, and ask it again why it failed."""
    shards = [
        Found(parquet.read(each, EXAMINED), parquet.read(other, FAILURE_ATTEMPTS))
        for each, other in zip(examined, attempts, strict=True)
    ]
    atlas = join(shards, settings.detector, settings, jobs)
    atlas.save(failures)
    log.info("%s", atlas)


if __name__ == "__main__":
    run_job(run)

"""explain_failures: a page that shows where a detector fails, and why."""

from pathlib import Path

from egad.bench.failures import FailureAtlas
from egad.report.failure_atlas import write_page
from egad.workflow.job import run_job


def run(failures: Path, page: Path, jobs: int) -> None:
    """Write the page of an atlas.

    Args:
        failures: Objects that the detector fails at; the other tables of the atlas are next to it.
        page: Map of the failures, their reasons and features of shape, and films of the worst.
        jobs: Processes.
    """
    write_page(FailureAtlas.load(failures), page, jobs=jobs)


if __name__ == "__main__":
    run_job(run)

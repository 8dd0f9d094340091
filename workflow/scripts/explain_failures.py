"""explain_failures: a page that shows where a detector fails, and why."""

from pathlib import Path

from egad.bench.failures import FailureAtlas
from egad.report.failure_atlas import write_page
from egad_workflow.job import run_job


def run(failures: Path, page: Path, jobs: int) -> None:
    """Write the page of an atlas, whose other tables are next to its failures."""
    write_page(FailureAtlas.load(failures), page, jobs=jobs)


if __name__ == "__main__":
    run_job(run)

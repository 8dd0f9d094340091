"""publish: the final archive, from which the objects are made."""

from pathlib import Path

from egad.tables import parquet
from egad.tables.evolution import ARCHIVE
from egad_workflow.job import run_job


def run(final: Path, archive: Path) -> None:
    """Publish the archive of the last epoch, without its internal columns."""
    parquet.write(parquet.read(final, ARCHIVE), ARCHIVE, archive, parquet.notes(final))


if __name__ == "__main__":
    run_job(run)

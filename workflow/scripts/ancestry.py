"""ancestry: the ancestors of the elites of an archive, back to random genomes."""

import logging
from pathlib import Path

import pandas as pd

from egad.evolution import ancestors
from egad.tables import parquet
from egad.tables.evolution import ARCHIVE, LINEAGE
from egad_workflow.job import run_job

log = logging.getLogger(__name__)


def run(archive: Path, lineages: list[Path], ancestry: Path) -> None:
    """Find the ancestors of the elites of an archive in the lineages of all islands and epochs."""
    ids = parquet.read(archive, ARCHIVE)["id"]
    born = pd.concat([parquet.read(path, LINEAGE) for path in lineages], ignore_index=True)
    table = ancestors(ids, born)
    parquet.write(table, LINEAGE, ancestry)
    founders = sum(len(parents) == 0 for parents in table["parents"])
    log.info("%d elites, %d ancestors, %d founders", len(ids), len(table) - len(ids), founders)


if __name__ == "__main__":
    run_job(run)

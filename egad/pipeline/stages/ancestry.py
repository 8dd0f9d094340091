"""ancestry: the ancestors of the elites of an archive, back to random genomes."""

import logging
from pathlib import Path
from typing import Annotated

import pandas as pd
import typer

from egad.map_elites import ancestors
from egad.pipeline.parameters import Input, Output, command
from egad.tables import parquet
from egad.tables.evolution import ARCHIVE, LINEAGE

log = logging.getLogger(__name__)


@command()
def run(
    archive: Annotated[Path, Input()],
    lineages: Annotated[list[Path], typer.Argument(), Input()],
    out: Annotated[Path, Output("D/ancestry.parquet", LINEAGE)],
) -> None:
    """Find the ancestors of the elites of an archive.

    Args:
        archive: The elites.
        lineages: What the archives of all islands took in, in all epochs.
        out: Elites and ancestors, in the order in which they were created.
    """
    ids = parquet.read(archive, ARCHIVE)["id"]
    born = pd.concat([parquet.read(path, LINEAGE) for path in lineages], ignore_index=True)
    table = ancestors(ids, born)
    parquet.write(table, LINEAGE, out)
    founders = sum(len(parents) == 0 for parents in table["parents"])
    log.info("%d elites, %d ancestors, %d founders", len(ids), len(table) - len(ids), founders)

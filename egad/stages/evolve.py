"""evolve: one epoch of one island."""

import logging
from pathlib import Path

from egad import tables
from egad.evolution.archive import Archive, elites_of
from egad.evolution.island import evolve
from egad.stage_settings import Evolve
from egad.workers import workers

log = logging.getLogger(__name__)


def run(
    settings: Evolve,
    epoch: int,
    island: int,
    base: Path | None,
    out: Path,
    history: Path,
    worker_count: int,
) -> None:
    """Evolve an archive for the steps of an epoch.

    Args:
        settings: What evolution reads.
        epoch: Number of the epoch.
        island: Number of the island.
        base: Merged archive of the epoch before; None to start from random genomes.
        out: The island's archive, with the columns of `egad.tables.EPOCH`.
        history: Its steps, with the columns of `egad.tables.HISTORY`.
        worker_count: Processes; the result does not depend on it.
    """
    with workers(worker_count) as mapper:
        archive = Archive(settings.space, settings.similarity)
        if base is not None:
            archive.add(elites_of(tables.read(base, tables.EPOCH)))
        steps, counts = evolve(archive, settings, epoch, island, mapper)
    tables.write(steps, tables.HISTORY, history)
    tables.write(archive.to_frame(), tables.EPOCH, out)
    log.info("%d elites, coverage %.3f", len(archive), archive.coverage)
    for outcome, count in sorted(counts.items()):
        log.info("%6d offspring: %s", count, outcome)

"""evolve: one epoch of one island."""

import logging
from pathlib import Path

from egad._util.progress import phase
from egad._util.workers import workers
from egad.errors import UserError, most_common
from egad.evolution import Archive, EvolutionParameters, elites_of, evolve, rules_of
from egad.measures import check_measures
from egad.tables import parquet
from egad.tables.evolution import EPOCH, HISTORY, LINEAGE
from egad_workflow.archive_settings import check_provenance, provenance
from egad_workflow.job import run_job

log = logging.getLogger(__name__)


def run(
    settings: EvolutionParameters,
    epoch: int,
    island: int,
    archive: Path,
    history: Path,
    lineage: Path,
    base: Path | None = None,
    jobs: int = 1,
) -> None:
    """Evolve one island for one epoch; without a merged archive as base, from random genomes."""
    check_measures(settings.measures)
    rules = rules_of(settings)
    with workers(jobs) as mapper:
        found = Archive(settings.space, settings.similarity, jobs)
        if base is not None:
            phase("reading the archive of the previous epoch")
            check_provenance(base, settings)
            found.add(elites_of(parquet.read(base, EPOCH)))
        done = evolve(found, settings, epoch, island, rules, mapper)
    counts = done.outcomes
    if not len(found):
        raise UserError(f"none of {counts.total()} offspring was accepted: {most_common(counts)}")
    parquet.write(done.history, HISTORY, history)
    parquet.write(done.lineage, LINEAGE, lineage)
    parquet.write(found.to_frame(), EPOCH, archive, provenance(settings))
    log.info("%d elites, coverage %.3f", len(found), found.coverage)
    for outcome, count in sorted(counts.items()):
        log.info("%6d offspring: %s", count, outcome)


if __name__ == "__main__":
    run_job(run)

"""evolve: one epoch of one island."""

import logging
from pathlib import Path

import trimesh

from egad._util.progress import phase
from egad._util.workers import workers
from egad.cppn.constraints import Rules, build_rules
from egad.errors import RejectedError, UserError
from egad.exchange.meshes import read_mesh
from egad.geometry.repair import repair
from egad.map_elites.archive import Archive, elites_of
from egad.map_elites.island import Watch, evolve
from egad.map_elites.parameters import EvolutionParameters
from egad.measures.custom import check_measures
from egad.pipeline.archive_settings import check_provenance, provenance
from egad.tables import parquet
from egad.tables.evolution import EPOCH, HISTORY

log = logging.getLogger(__name__)


def run(
    settings: EvolutionParameters,
    epoch: int,
    island: int,
    base: Path | None,
    out: Path,
    history: Path,
    worker_count: int,
    watch: Watch | None = None,
) -> None:
    """Evolve an archive for the steps of an epoch.

    Args:
        settings: What evolution reads.
        epoch: Number of the epoch.
        island: Number of the island.
        base: Merged archive of the epoch before; None to start from random genomes.
        out: The island's archive, with the columns of `tables.evolution.EPOCH`.
        history: Its steps, with the columns of `tables.evolution.HISTORY`.
        worker_count: Processes, and threads; the result does not depend on it.
        watch: Is told of the archive and its steps after each of them.
    """
    check_measures(settings.axes)
    rules = rules_of(settings)
    with workers(worker_count) as mapper:
        archive = Archive(settings.space, settings.similarity, worker_count)
        if base is not None:
            phase("reading the archive of the epoch before")
            check_provenance(base, settings)
            archive.add(elites_of(parquet.read(base, EPOCH)))
        steps, counts = evolve(archive, settings, epoch, island, rules, mapper, watch)
    if not len(archive):
        most = "; ".join(f"{reason} ({count})" for reason, count in counts.most_common(3))
        raise UserError(f"none of {counts.total()} offspring could be kept: {most}")
    parquet.write(steps, HISTORY, history)
    parquet.write(archive.to_frame(), EPOCH, out, provenance(settings))
    log.info("%d elites, coverage %.3f", len(archive), archive.coverage)
    for outcome, count in sorted(counts.items()):
        log.info("%6d offspring: %s", count, outcome)


def rules_of(settings: EvolutionParameters) -> Rules:
    """What every shape must obey.

    Raises:
        UserError: Nothing could grow by these rules, or a mesh cannot be used.
    """
    return build_rules(
        settings.shape.resolution,
        mesh_of,
        envelope=settings.envelope,
        part=settings.part,
        hole=settings.hole,
        symmetry=settings.symmetry,
        limits=settings.limits,
    )


def mesh_of(path: str) -> trimesh.Trimesh:
    """The closed mesh in a file that a region names.

    Raises:
        UserError: The file cannot be used, or holds several bodies.
    """
    try:
        mesh = read_mesh(Path(path), "m")
        closed = repair(mesh).mesh
    except RejectedError as reason:
        raise UserError(f"the mesh {path} of a region cannot be used: {reason}") from reason
    if mesh.body_count > 1:
        raise UserError(f"the mesh {path} of a region has {mesh.body_count} parts; one is allowed")
    return closed

"""evolve: one epoch of one island."""

import importlib
import logging
from pathlib import Path
from typing import Annotated

import trimesh

from egad._util.progress import phase
from egad._util.workers import workers
from egad.cppn import Rules, build_rules
from egad.errors import RejectedError, UserError, most_common
from egad.exchange import read_mesh
from egad.geometry.repair import repair
from egad.map_elites import Archive, EvolutionParameters, Watch, elites_of, evolve
from egad.measures import check_measures
from egad.pipeline.archive_settings import check_provenance, provenance
from egad.pipeline.parameters import Input, Jobs, NotNoted, Output, command
from egad.tables import parquet
from egad.tables.evolution import EPOCH, HISTORY, LINEAGE

log = logging.getLogger(__name__)


@command()
def run(
    settings: EvolutionParameters,
    epoch: int,
    island: int,
    out: Annotated[Path, Output(schema=EPOCH)],
    history: Annotated[Path, Output("D/history.parquet", HISTORY)],
    lineage: Annotated[Path, Output(schema=LINEAGE)],
    base: Annotated[Path | None, Input()] = None,
    page: Annotated[Path | None, NotNoted()] = None,
    islands: Annotated[int | None, NotNoted()] = None,
    jobs: Jobs = 1,
) -> None:
    """Evolve one island for one epoch.

    Args:
        settings: Settings of this stage.
        epoch: Number of the epoch.
        island: Number of the island.
        out: Archive of the island.
        history: Statistics of the archive, one row per step.
        lineage: All objects that the archive took in, even if they left it again.
        base: Merged archive of the previous epoch; none starts from random genomes.
        page: HTML page to write, a live map of the archive.
        islands: Number of islands, for the page.
        jobs: Processes, and threads; the result does not depend on it.
    """
    check_measures(settings.measures)
    rules = rules_of(settings)
    watch = watch_of(settings, epoch, island, page, islands) if page else None
    with workers(jobs) as mapper:
        archive = Archive(settings.space, settings.similarity, jobs)
        if base is not None:
            phase("reading the archive of the epoch before")
            check_provenance(base, settings)
            archive.add(elites_of(parquet.read(base, EPOCH)))
        done = evolve(archive, settings, epoch, island, rules, mapper, watch)
    counts = done.outcomes
    if not len(archive):
        raise UserError(f"none of {counts.total()} offspring was accepted: {most_common(counts)}")
    parquet.write(done.history, HISTORY, history)
    parquet.write(done.lineage, LINEAGE, lineage)
    parquet.write(archive.to_frame(), EPOCH, out, provenance(settings))
    log.info("%d elites, coverage %.3f", len(archive), archive.coverage)
    for outcome, count in sorted(counts.items()):
        log.info("%6d offspring: %s", count, outcome)


def watch_of(
    settings: EvolutionParameters, epoch: int, island: int, page: Path, islands: int | None
) -> Watch:
    """The live map of the archive.

    It is imported by name: the page does not affect results, so its changes must not re-run jobs.
    """
    live_map = importlib.import_module("egad.report.live_map")
    record = importlib.import_module("egad.pipeline.provenance.record")
    axes = importlib.import_module("egad.report.axes")
    evaluations = settings.evolution.steps_per_epoch * settings.evolution.population
    run = record.settings_hash(settings)
    about = live_map.EpochOfIsland(run, epoch, island, evaluations, islands)
    names = axes.axis_pair(settings.measures)
    watch: Watch = live_map.LiveMap(page, about, settings.space, settings.shape.resolution, names)
    return watch


def rules_of(settings: EvolutionParameters, resolution: int | None = None) -> Rules:
    """The constraints on all shapes.

    Args:
        settings: All constraints.
        resolution: Voxels along each side of the cube; None: as shapes evolve.

    Raises:
        UserError: The constraints leave no voxel to grow in, or a mesh cannot be used.
    """
    return build_rules(
        resolution or settings.shape.resolution,
        mesh_of,
        envelope=settings.envelope,
        keep_solid=settings.keep_solid,
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

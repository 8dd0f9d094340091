"""export_meshes: the meshes of an archive, at its resolution or another one."""

import logging
from collections.abc import Callable, Collection
from functools import partial
from pathlib import Path
from typing import Any

import trimesh

from egad._util.files import atomic_output
from egad._util.progress import progress
from egad._util.workers import workers
from egad.cppn import UNBOUND, Rules, check_regrown, genome_mesh, packed_surface, unpack
from egad.errors import RejectedError, UserError
from egad.exchange import write_obj
from egad.pipeline.config import Shape
from egad.tables import parquet
from egad.tables.columns import check_names
from egad.tables.evolution import ARCHIVE, GENOME

log = logging.getLogger(__name__)


def run(
    archive: Path,
    out: Path,
    shape: Shape,
    resolution: int | None = None,
    rules: Callable[[int], Rules] = lambda _: UNBOUND,
    ids: Collection[str] | None = None,
    jobs: int = 1,
) -> int:
    """Write objects of an archive as `ID.obj`, in metres, as measured during evolution.

    Args:
        archive: Table with the columns of `tables.evolution.ARCHIVE`.
        out: Folder to make.
        shape: The settings that the archive was evolved with.
        resolution: Voxels along each side of the cube; None: those of the archive.
        rules: Gives the constraints that the archive was evolved with, at a resolution.
        ids: Objects to write; None: all.
        jobs: Processes.

    Returns:
        Number of meshes written. Objects of which nothing is left at the resolution are logged.

    Raises:
        TableError: The archive is damaged, or an id in it is not a valid file name.
        UserError: A genome does not describe its voxels within these constraints.
    """
    frame = parquet.read(archive, ARCHIVE)
    check_names(frame, archive, ["id"])
    frame = frame if ids is None else frame[frame["id"].isin(list(ids))]
    rows = frame[["id", "voxels", *GENOME.names]].to_dict("records")
    make: Callable[[dict[str, Any]], trimesh.Trimesh] = partial(_stored, shape=shape)
    if resolution not in (None, shape.resolution):
        found, checked = rules(resolution), rules(shape.resolution)
        make = partial(_grown, shape=shape, resolution=resolution, rules=found, checked=checked)
    missing = 0
    with atomic_output(out) as folder, workers(jobs) as mapper:
        folder.mkdir()
        reasons = mapper(partial(_write, make=make, folder=folder), rows)
        for row, reason in zip(rows, progress(reasons, "writing meshes", len(rows)), strict=True):
            if reason:
                missing += 1
                log.info("no mesh of %s: %s", row["id"], reason)
    return len(rows) - missing


def _write(
    row: dict[str, Any], make: Callable[[dict[str, Any]], trimesh.Trimesh], folder: Path
) -> str:
    """Write the mesh of an object; the reason if there is none."""
    try:
        mesh = make(row)
    except RejectedError as reason:
        return str(reason)
    write_obj(mesh, folder / f"{row['id']}.obj")
    return ""


def _stored(row: dict[str, Any], shape: Shape) -> trimesh.Trimesh:
    """The mesh of the voxels in the archive."""
    return packed_surface(row["voxels"], shape)


def _grown(
    row: dict[str, Any], shape: Shape, resolution: int, rules: Rules, checked: Rules
) -> trimesh.Trimesh:
    """The mesh of a genome at another resolution."""
    voxels = unpack(row["voxels"], shape.resolution)
    try:
        check_regrown(row, voxels, shape.threshold, checked)
    except UserError as error:
        raise UserError(f"{row['id']}: {error}") from error
    return genome_mesh(row, resolution, shape=shape, rules=rules)

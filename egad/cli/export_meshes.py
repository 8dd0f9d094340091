"""The meshes of an archive, at its resolution or another one."""

import logging
from collections.abc import Callable, Collection
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from egad._util.progress import progress
from egad._util.workers import workers
from egad.cli import common
from egad.errors import RejectedError, UserError
from egad.evolution import COARSEST, FINEST, Shape
from egad_workflow.settings import select

if TYPE_CHECKING:
    import trimesh

    from egad.evolution import Rules

log = logging.getLogger(__name__)


def export_meshes(
    archive: common.ArchiveFile,
    out: common.OutFolder,
    resolution: Annotated[
        int | None,
        typer.Option(
            min=COARSEST, max=FINEST, help="voxels along each side; default: those of the archive"
        ),
    ] = None,
    objects: Annotated[
        list[str] | None,
        typer.Option("--object", help="label or id; may be repeated; default: all objects"),
    ] = None,
    config: common.Config = None,
    jobs: common.Jobs = common.CORES,
) -> None:
    """Write the meshes of an archive as ID.obj, in metres, without repair."""
    from egad.data import archive_path
    from egad.evolution import EvolutionParameters, rules_of
    from egad.objects import load
    from egad_workflow.archive_settings import check_provenance

    common.check_spare(out)
    archive, settings = archive_path(archive), common.settings_in(config)
    if archive.is_dir() and not (archive / "archive.parquet").is_file():
        raise UserError(f"{archive} has no archive.parquet: its objects come from meshes")
    archive = archive / "archive.parquet" if archive.is_dir() else archive
    breeding = select(settings, EvolutionParameters)
    check_provenance(archive, breeding, ("shape",))
    ids = None if objects is None else load(archive).select(objects).table["id"].tolist()
    rules = partial(rules_of, breeding)
    count = write_meshes(archive, out, settings.shape, resolution, rules, ids, jobs)
    typer.echo(f"{count} meshes in {out}")


def write_meshes(
    archive: Path,
    out: Path,
    shape: Shape,
    resolution: int | None = None,
    rules: "Callable[[int], Rules] | None" = None,
    ids: Collection[str] | None = None,
    jobs: int = 1,
) -> int:
    """Write objects of an archive as `ID.obj`, metres, in single precision; return how many."""
    from egad._util.files import atomic_output
    from egad.evolution import UNBOUND
    from egad.tables import parquet
    from egad.tables.columns import check_names
    from egad.tables.evolution import ARCHIVE, GENOME

    frame = parquet.read(archive, ARCHIVE)
    check_names(frame, archive, ["id"])
    frame = frame if ids is None else frame[frame["id"].isin(list(ids))]
    rows = frame[["id", "voxels", *GENOME.names]].to_dict("records")
    make: Callable[[dict[str, Any]], trimesh.Trimesh] = partial(_stored, shape=shape)
    if resolution not in (None, shape.resolution):
        bound = rules or (lambda _: UNBOUND)
        found, checked = bound(resolution), bound(shape.resolution)
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
    row: dict[str, Any], make: "Callable[[dict[str, Any]], trimesh.Trimesh]", folder: Path
) -> str:
    """Write the mesh of an object; returns the reason if there is none."""
    from egad.io import write_obj

    try:
        mesh = make(row)
    except RejectedError as reason:
        return str(reason)
    write_obj(mesh, folder / f"{row['id']}.obj")
    return ""


def _stored(row: dict[str, Any], shape: Shape) -> "trimesh.Trimesh":
    from egad.evolution import packed_surface
    from egad.geometry import in_single_precision

    return in_single_precision(packed_surface(row["voxels"], shape))


def _grown(
    row: dict[str, Any], shape: Shape, resolution: int, rules: "Rules", checked: "Rules"
) -> "trimesh.Trimesh":
    """The mesh of a genome at another resolution."""
    from egad.evolution import check_regrown, genome_mesh, unpack

    voxels = unpack(row["voxels"], shape.resolution)
    try:
        check_regrown(row, voxels, shape.threshold, checked)
    except UserError as error:
        raise UserError(f"{row['id']}: {error}") from error
    return genome_mesh(row, resolution, shape=shape, rules=rules)

"""release-archive: the objects of a dataset release for simulators, in one ZIP archive."""

import logging
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

import typer

from egad._util.files import atomic_output
from egad._util.progress import progress
from egad.exchange import (
    PHYSICS_WRITERS,
    check_installed,
    mesh_files,
    read_convex_objects,
    write_zip,
)
from egad.pipeline.config import Bundle, Material
from egad.pipeline.config.stage_settings import StageSettings
from egad.pipeline.parameters import Input, Output, command

log = logging.getLogger(__name__)


class ReleaseArchive(StageSettings):
    """Mass and friction of the objects in an archive."""

    material: Material
    bundle: Bundle


@command()
def run(
    settings: ReleaseArchive,
    style: Annotated[str, typer.Option("--format")],
    meshes: Annotated[Path, Input()],
    convex_parts: Annotated[Path, Input()],
    out: Annotated[Path, Output("release/archives/FORMAT.zip")],
) -> None:
    """Write all objects that have convex parts in a format for simulators.

    Args:
        settings: Density and friction.
        style: The format, such as `urdf`.
        meshes: Folder of the scaled meshes.
        convex_parts: Convex parts of the objects, sorted by label.
        out: Objects for simulators, scaled to the gripper of the release, for each FORMAT of
            `release.archives`. An object without convex parts is missing.

    Raises:
        UserError: The format needs a package that is not installed.
    """
    check_installed(style)
    count = len(mesh_files(meshes, "*.obj"))
    with atomic_output(out, keep=False) as path:
        write_zip(path, _written(settings, style, meshes, convex_parts, count))


def _written(
    settings: ReleaseArchive, style: str, meshes: Path, convex_parts: Path, count: int
) -> Iterator[Path]:
    """A folder with the files of each object, which is gone when the next one is asked for."""
    written = 0
    found = read_convex_objects(convex_parts, meshes, settings.material.density)
    for label, made in progress(found, "writing objects", count):
        with TemporaryDirectory() as folder:
            PHYSICS_WRITERS[style](Path(folder), label, made, settings.bundle.friction)
            yield Path(folder)
        written += 1
    log.info("%d of %d objects", written, count)

"""release-archive: the objects of a dataset release for simulators, in one ZIP archive."""

import logging
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

from egad._util.files import atomic_output
from egad._util.progress import progress
from egad.exchange import WriteObject, read_convex_objects, writer_of
from egad.io import mesh_files, write_zip
from egad.sim import SimulationBundle
from egad_workflow.job import run_job

log = logging.getLogger(__name__)


def run(
    settings: SimulationBundle, format_name: str, meshes: Path, convex_parts: Path, out: Path
) -> None:
    """Write all objects that have convex parts, sorted by label, in a format for simulators."""
    write = writer_of(format_name)
    count = len(mesh_files(meshes, "*.obj"))
    with atomic_output(out, keep=False) as path:
        write_zip(path, _written(settings, write, meshes, convex_parts, count))


def _written(
    settings: SimulationBundle, write: WriteObject, meshes: Path, convex_parts: Path, count: int
) -> Iterator[Path]:
    """A folder with the files of each object, which is deleted when the next one is requested."""
    written = 0
    found = read_convex_objects(convex_parts, meshes, settings.material.density)
    for label, made in progress(found, "writing objects", count):
        with TemporaryDirectory() as folder:
            write(Path(folder), label, made, settings.bundle.friction)
            yield Path(folder)
        written += 1
    log.info("%d of %d objects", written, count)


if __name__ == "__main__":
    run_job(run)

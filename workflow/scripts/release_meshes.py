"""release-meshes: the meshes of a dataset release as GLB."""

from collections import deque
from functools import partial
from pathlib import Path

from egad._util.files import atomic_output
from egad._util.progress import progress
from egad._util.workers import workers
from egad.exchange.release import file_stems
from egad.io import read_mesh, write_glb
from egad.tables import parquet
from egad.tables.objects import OBJECTS
from egad_workflow.job import run_job


def run(objects: Path, meshes: Path, out: Path, jobs: int = 1) -> None:
    """Write the mesh of each object as GLB, in metres, not scaled; glTF is Y up."""
    stems = file_stems(parquet.read(objects, OBJECTS)["label"])
    with workers(jobs) as mapper, atomic_output(out) as folder:
        folder.mkdir()
        written = mapper(partial(_write, meshes, folder), list(stems.items()))
        deque(progress(written, "writing meshes", len(stems)), maxlen=0)


def _write(meshes: Path, folder: Path, item: tuple[str, str]) -> None:
    label, stem = item
    write_glb(read_mesh(meshes / f"{label}.obj", "m"), folder / f"{stem}.glb")


if __name__ == "__main__":
    run_job(run)

"""release-previews: a small picture of each object of a dataset release."""

from collections import deque
from functools import partial
from pathlib import Path

from egad._util.files import atomic_output
from egad._util.progress import progress
from egad._util.workers import workers
from egad.io import read_mesh
from egad.report.pictures import png_bytes, render
from egad.tables import parquet
from egad.tables.objects import OBJECTS
from egad.workflow.job import run_job

SIZE = 192  # pixels along each side


def run(
    objects: Path,
    meshes: Path,
    out: Path,
    jobs: int = 1,
) -> None:
    """Draw each object.

    Args:
        objects: Objects of the dataset.
        meshes: Folder of their meshes.
        out: Pictures of the objects on a transparent ground, z up, each scaled to fill the
            picture.
        jobs: Processes; the result does not depend on it.
    """
    labels = parquet.read(objects, OBJECTS)["label"].tolist()
    with workers(jobs) as mapper, atomic_output(out) as folder:
        folder.mkdir()
        work = partial(_draw, meshes, folder)
        deque(progress(mapper(work, labels), "drawing objects", len(labels)), maxlen=0)


def _draw(meshes: Path, folder: Path, label: str) -> None:
    mesh = read_mesh(meshes / f"{label}.obj", "m")
    (folder / f"{label}.png").write_bytes(png_bytes(render(mesh, SIZE)))


if __name__ == "__main__":
    run_job(run)

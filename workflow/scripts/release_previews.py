"""release-previews: a small picture of each object of a dataset release."""

from collections import deque
from functools import partial
from pathlib import Path

from egad._util.files import atomic_output
from egad._util.progress import progress
from egad._util.workers import workers
from egad.exchange.release import file_stems
from egad.io import read_mesh
from egad.report.pictures import png_bytes, render
from egad.tables import parquet
from egad.tables.objects import OBJECTS
from egad_workflow.job import run_job

SIZE = 192  # pixels along each side


def run(objects: Path, meshes: Path, out: Path, jobs: int = 1) -> None:
    """Draw each object on a transparent ground, z up, scaled to fill the picture."""
    stems = file_stems(parquet.read(objects, OBJECTS)["label"])
    with workers(jobs) as mapper, atomic_output(out) as folder:
        folder.mkdir()
        work = partial(_draw, meshes, folder)
        drawn = mapper(work, list(stems.items()))
        deque(progress(drawn, "drawing objects", len(stems)), maxlen=0)


def _draw(meshes: Path, folder: Path, item: tuple[str, str]) -> None:
    label, stem = item
    path = folder / f"{stem}.png"
    path.parent.mkdir(exist_ok=True)
    path.write_bytes(png_bytes(render(read_mesh(meshes / f"{label}.obj", "m"), SIZE)))


if __name__ == "__main__":
    run_job(run)

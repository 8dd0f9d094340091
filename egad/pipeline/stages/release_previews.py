"""release-previews: a small picture of each object of a dataset release."""

from collections import deque
from functools import partial
from pathlib import Path
from typing import Annotated

from egad._util.files import atomic_output
from egad._util.progress import progress
from egad._util.workers import workers
from egad.exchange import read_mesh
from egad.pipeline.parameters import Input, Jobs, Output, command
from egad.report.pictures import png_bytes, render
from egad.tables import parquet
from egad.tables.objects import OBJECTS

SIZE = 192  # pixels along each side


@command()
def run(
    objects: Annotated[Path, Input()],
    meshes: Annotated[Path, Input()],
    out: Annotated[Path, Output("release/previews/LABEL.png")],
    jobs: Jobs = 1,
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

"""Objects of a dataset: their cells, labels and meshes."""

from collections import deque
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
import trimesh
from numpy.typing import NDArray

from egad._util.files import atomic_output
from egad._util.progress import progress
from egad._util.workers import workers
from egad.config.stages import CellsAndDiversities
from egad.io import write_obj
from egad.measures import complexity_cells, difficulty_cells, labels
from egad.measures.reeb import diversities
from egad.measures.reeb import graph as reeb


def arrange(
    frame: pd.DataFrame, settings: CellsAndDiversities, evolved: bool, threads: int = 1
) -> pd.DataFrame:
    """Add cells, diversities and labels; sort by label."""
    graphs = [reeb.unpack(data) for data in frame["graph"]]
    space = settings.space
    frame = frame.assign(
        complexity_cell=complexity_cells(frame["complexity"], space),
        difficulty_cell=difficulty_cells(frame["graspability"], space),
        diversity=diversities(graphs, settings.similarity.weight, space.neighbors, threads, _shown),
    )
    if not evolved:
        return frame.assign(label=frame["id"]).sort_values("label", ignore_index=True)
    frame = frame.sort_values(
        ["difficulty_cell", "complexity_cell", "diversity", "id"],
        ascending=[True, True, False, True],
        ignore_index=True,
    )
    return frame.assign(label=labels(frame["complexity_cell"], frame["difficulty_cell"]))


def _shown(batches: list[NDArray[np.int64]]) -> Iterator[NDArray[np.int64]]:
    return progress(batches, "comparing objects, batches", len(batches))


def write_meshes(frame: pd.DataFrame, out: Path, jobs: int = 1) -> None:
    """Write the meshes of objects, `label`, `vertices` and `faces`, as `LABEL.obj`, in metres."""
    with workers(jobs) as mapper, atomic_output(out) as folder:
        folder.mkdir()
        columns = zip(frame["label"], frame["vertices"], frame["faces"], strict=True)
        written = mapper(partial(_write, folder), columns)
        deque(progress(written, "writing meshes", len(frame)), maxlen=0)


def _write(folder: Path, row: tuple[str, np.ndarray, np.ndarray]) -> None:
    label, vertices, faces = row
    mesh = trimesh.Trimesh(vertices.reshape(-1, 3), faces.reshape(-1, 3), process=False)
    write_obj(mesh, folder / f"{label}.obj")

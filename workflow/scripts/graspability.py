"""graspability: graspability of the objects of a dataset, for one gripper."""

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from egad._util.progress import progress
from egad._util.workers import workers
from egad.errors import RejectedError
from egad.io import read_mesh
from egad.measures import GraspabilityOfGripper, measure_repeatably
from egad.tables import parquet
from egad.tables.objects import GRASPABILITIES, OBJECTS
from egad_workflow.job import run_job


def run(
    settings: GraspabilityOfGripper, objects: Path, meshes: Path, out: Path, jobs: int = 1
) -> None:
    """Measure the graspability of every object for a gripper, in the same way as for its cell."""
    labels = parquet.read(objects, OBJECTS)["label"].tolist()
    with workers(jobs) as mapper:
        rows = mapper(partial(_row, meshes=meshes, settings=settings), labels)
        table = pd.DataFrame(progress(rows, "measuring", len(labels)), columns=GRASPABILITIES.names)
    parquet.write(table, GRASPABILITIES, out)


def _row(label: str, meshes: Path, settings: GraspabilityOfGripper) -> dict[str, Any]:
    """The graspability of an object; missing if it has no grasp."""
    most = settings.postprocess.max_candidates
    try:
        mesh = read_mesh(meshes / f"{label}.obj", "m")
        found = measure_repeatably(mesh, settings, most, resample=False)
    except RejectedError:
        return {"label": label, "graspability": np.nan, "graspability_std": np.nan, "grasps": 0}
    return {name: getattr(found, name) for name in GRASPABILITIES.names[1:]} | {"label": label}


if __name__ == "__main__":
    run_job(run)

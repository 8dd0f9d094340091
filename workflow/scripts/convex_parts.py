"""convex-parts: the convex parts of the objects of a shard, scaled to a gripper."""

import logging
from pathlib import Path

import pandas as pd

from egad._util.progress import progress
from egad.errors import RejectedError
from egad.io import read_mesh
from egad.sim import SimulationBundle, make_simulation_object, part_rows
from egad.tables import parquet
from egad.tables.evaluation import CONVEX_PARTS
from egad.tables.objects import OBJECTS
from egad_workflow.job import run_job
from egad_workflow.shards import rows_in_shard

log = logging.getLogger(__name__)


def run(
    settings: SimulationBundle, objects: Path, meshes: Path, shard: tuple[int, int], out: Path
) -> None:
    """Make the convex parts of the objects of a shard; the log names objects without any."""
    frame = rows_in_shard(parquet.read(objects, OBJECTS), *shard)
    made = []
    names = zip(frame["id"], frame["label"], strict=True)
    for object_id, label in progress(names, "making convex parts", len(frame)):
        try:
            mesh = read_mesh(meshes / f"{label}.obj", "m")
            density, bundle = settings.material.density, settings.bundle
            found = make_simulation_object(mesh, density, bundle, label)
        except RejectedError as reason:
            log.warning("%s has no convex parts: %s", label, reason)
        else:
            made.append(part_rows(found).assign(label=label, id=object_id))
    table = pd.concat(made) if made else parquet.empty(CONVEX_PARTS)
    parquet.write(table, CONVEX_PARTS, out)
    log.info("%d parts of %d objects", len(table), len(made))


if __name__ == "__main__":
    run_job(run)

"""grasp-label: labelled grasps of the objects of a shard, scaled to a gripper."""

import logging
from pathlib import Path

import pandas as pd

from egad._util.progress import progress
from egad.errors import RejectedError
from egad.geometry import center_of_mass
from egad.grasps import LabelParameters, statistics_row
from egad.grasps.sampling import Labeller
from egad.io import read_mesh
from egad.random import generator
from egad.tables import parquet
from egad.tables.grasping import GRASPS, SAMPLING
from egad.tables.objects import OBJECTS, REJECTED, rejection
from egad_workflow.job import run_job
from egad_workflow.shards import rows_in_shard

log = logging.getLogger(__name__)


def run(
    settings: LabelParameters,
    objects: Path,
    meshes: Path,
    shard: tuple[int, int],
    out: Path,
    sampling: Path,
    rejected: Path,
) -> None:
    """Label the grasps of the objects of a shard."""
    frame = parquet.read(objects, OBJECTS)
    frame = rows_in_shard(frame, *shard)
    label, wanted = Labeller(settings), settings.grasp_label.grasps
    labelled, statistics, left_out = [], [], []
    names = zip(frame["id"], frame["label"], strict=True)
    for object_id, object_label in progress(names, "labelling grasps", len(frame)):
        named = {"id": object_id, "label": object_label}
        try:
            mesh = read_mesh(meshes / f"{object_label}.obj", "m")
            found = label(mesh, center_of_mass(mesh), generator(settings.seed, "grasps", object_id))
        except RejectedError as reason:
            left_out.append(rejection(object_id, "grasp-label", reason))
            continue
        rows = parquet.empty(GRASPS) if found.reason else found.table
        if found.reason:
            left_out.append(rejection(object_id, "grasp-label", found.reason))
        else:
            labelled.append(rows.assign(**named))
        statistics.append(named | statistics_row(wanted, found.statistics, rows))
    table = pd.concat(labelled) if labelled else parquet.empty(GRASPS)
    parquet.write(table, GRASPS, out)
    parquet.write(pd.DataFrame(statistics), SAMPLING, sampling)
    parquet.write(pd.DataFrame(left_out), REJECTED, rejected)
    log.info("%d grasps, %d objects without any", len(table), len(left_out))


if __name__ == "__main__":
    run_job(run)

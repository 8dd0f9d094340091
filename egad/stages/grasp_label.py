"""grasp-label: labelled grasps of the objects of a shard, scaled to a gripper."""

import logging
from pathlib import Path

import pandas as pd

from egad.errors import RejectedError
from egad.exchange.meshes import read_mesh
from egad.grasps.labels import label
from egad.progress import progress
from egad.seeds import generator
from egad.stage_settings import GraspLabels
from egad.stages.shards import rejection, rows_in_shard
from egad.tables import parquet
from egad.tables.grasping import GRASPS
from egad.tables.objects import OBJECTS, REJECTED

log = logging.getLogger(__name__)


def run(
    settings: GraspLabels,
    objects: Path,
    meshes: Path,
    shard: tuple[int, int],
    out: Path,
    rejected: Path,
) -> None:
    """Label the grasps of the objects of a shard.

    Args:
        settings: What this stage reads.
        objects: Table with the columns of `tables.objects.OBJECTS`.
        meshes: Folder of the scaled meshes; grasps are in the frame of these.
        shard: Number of the shard, and of how many.
        out: Table with the columns of `tables.grasping.GRASPS`.
        rejected: Table of the objects that have no grasp.
    """
    frame = parquet.read(objects, OBJECTS)
    frame = rows_in_shard(frame, *shard)
    labelled, left_out = [], []
    names = zip(frame["id"], frame["label"], strict=True)
    for object_id, object_label in progress(names, "labelling grasps", len(frame)):
        try:
            mesh = read_mesh(meshes / f"{object_label}.obj", "m")
            rng = generator(settings.seed, "grasps", object_id)
            grasps = label(mesh, mesh.center_mass, settings, rng)
        except RejectedError as reason:
            left_out.append(rejection(object_id, "grasp-label", reason))
        else:
            labelled.append(grasps.assign(id=object_id, label=object_label))
    table = pd.concat(labelled) if labelled else parquet.empty(GRASPS)
    parquet.write(table, GRASPS, out)
    parquet.write(pd.DataFrame(left_out), REJECTED, rejected)
    log.info("%d grasps, %d objects without any", len(table), len(left_out))

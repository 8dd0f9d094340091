"""dexnet-objects: the objects of a shard for a Dex-Net database."""

import os
from pathlib import Path

from egad.config.stages import DexNetObjects
from egad.workflow.dexnet_objects import write_objects
from egad.workflow.job import run_job


def run(
    settings: DexNetObjects, objects: Path, meshes: Path, shard: tuple[int, int], out: Path
) -> None:
    """Write the objects of a shard for a Dex-Net database: distance fields, stable poses.

    Args:
        settings: Settings of this stage.
        objects: Objects of the dataset.
        meshes: Folder of the scaled meshes.
        shard: Number of this shard, and number of shards.
        out: HDF5 file with one group per object in its group `objects`.
    """
    os.environ["IGL_NUM_THREADS"] = "1"  # jobs run side by side
    write_objects(settings, objects, meshes, shard, out)


if __name__ == "__main__":
    run_job(run)

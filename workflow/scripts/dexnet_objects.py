"""dexnet-objects: the objects of a shard for a Dex-Net database."""

import os
from pathlib import Path

from egad.exchange import DexNetObjects
from egad.exchange.dexnet_database import write_objects
from egad.tables import parquet
from egad.tables.objects import OBJECTS
from egad_workflow.job import run_job
from egad_workflow.shards import rows_in_shard


def run(
    settings: DexNetObjects, objects: Path, meshes: Path, shard: tuple[int, int], out: Path
) -> None:
    """Write the objects of a shard for a Dex-Net database: distance fields, stable poses."""
    rows = rows_in_shard(parquet.read(objects, OBJECTS), *shard)
    write_objects(settings, parquet.records(rows), meshes, out)


if __name__ == "__main__":
    os.environ["IGL_NUM_THREADS"] = "1"  # jobs run side by side
    run_job(run)

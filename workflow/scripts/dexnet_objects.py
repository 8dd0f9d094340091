"""dexnet-objects: the objects of a shard for a Dex-Net database."""

import os

from egad.workflow.dexnet_objects import write_objects as run
from egad.workflow.job import run_job

if __name__ == "__main__":
    os.environ["IGL_NUM_THREADS"] = "1"  # jobs run side by side
    run_job(run)

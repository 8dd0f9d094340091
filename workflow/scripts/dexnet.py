"""dexnet: the Dex-Net database of a dataset, with the labelled grasps of a gripper."""

from egad.exchange.grasps.dexnet import run
from egad_workflow.job import run_job

if __name__ == "__main__":
    run_job(run)

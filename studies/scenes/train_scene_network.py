"""A network that grasps in six degrees of freedom, trained on labelled scenes."""

from egad.workflow.job import run_job
from egad.workflow.train_on_scenes import train_on_scenes as run

if __name__ == "__main__":
    run_job(run)

"""A network that grasps in six degrees of freedom, trained on labelled scenes."""

from egad.learning.train_on_scenes import train_on_scenes as run
from egad_workflow.job import run_job

if __name__ == "__main__":
    run_job(run)

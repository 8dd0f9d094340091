"""A grasp network, trained on the rendered images of one or several sets."""

from egad.learning.train_on_images import train as run
from egad_workflow.job import run_job

if __name__ == "__main__":
    run_job(run)

"""A grasp network, trained on the rendered images of one or several sets."""

from egad.workflow.job import run_job
from egad.workflow.train import train as run

if __name__ == "__main__":
    run_job(run)

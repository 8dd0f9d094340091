"""A grasp network, trained on the rendered images of one or several sets."""

from pathlib import Path

from egad.config.stages import TrainNetwork
from egad.workflow.job import run_job
from egad.workflow.train import train


def run(settings: TrainNetwork, images: list[Path], out: Path, jobs: int = 1) -> None:
    """Train a network; an interrupted training resumes after its last epoch.

    Args:
        settings: Settings of this stage.
        images: Folders of images in the compact layout, used as one set.
        out: Folder to write: weights, model card, history, score.
        jobs: Cores; no result depends on it.
    """
    train(settings, images, out, jobs)


if __name__ == "__main__":
    run_job(run)

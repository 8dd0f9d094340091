"""A network that grasps in six degrees of freedom, trained on labelled scenes."""

from pathlib import Path

from egad.config.stages import TrainOnScenes
from egad.workflow.job import run_job
from egad.workflow.train_on_scenes import train_on_scenes


def run(settings: TrainOnScenes, gripper: str, scenes: Path, out: Path, jobs: int = 1) -> None:
    """Train a network; an interrupted training resumes after its last epoch.

    Args:
        settings: Settings of this stage.
        gripper: Its name.
        scenes: Folder of labelled scenes.
        out: Folder to write: weights, model card, history, score.
        jobs: Cores; no result depends on it.
    """
    train_on_scenes(settings, gripper, [scenes], out, jobs)


if __name__ == "__main__":
    run_job(run)

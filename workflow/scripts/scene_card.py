"""scene-card: a readable description of a set of labelled scenes."""

import logging
from pathlib import Path

from egad.learning.scenes import SceneParameters, describe_set
from egad.tables.shards import remove_leftovers
from egad.workflow.job import run_job
from egad.workflow.scene_inputs import read_plan

log = logging.getLogger(__name__)


def run(
    settings: SceneParameters,
    dataset: str,
    gripper: str,
    folder: Path,
    shards: int,
    objects: Path,
    scales: Path,
    convex_parts: Path,
    evaluation: Path | None = None,
    ancestry: Path | None = None,
) -> None:
    """Write the card of a set of scenes: counts, labels, splits, cameras, noise.

    Args:
        settings: Settings that the scenes were made with.
        dataset: Name of the dataset.
        gripper: Name of the gripper.
        folder: Folder of the scenes; leftovers of an earlier, larger set are removed.
        shards: Number of shards.
        objects: Objects of the dataset.
        scales: Their scales for the gripper.
        convex_parts: Their convex parts.
        evaluation: Evaluation set that is held out.
        ancestry: Objects and their ancestors.
    """
    remove_leftovers(folder, ["scenes", "grasps"], shards)
    plan = read_plan(settings, objects, scales, convex_parts, evaluation, ancestry)
    title = f"Labelled scenes of {dataset} for {gripper}"
    found = describe_set(folder, settings, title, len(plan.scenes), plan.splits, plan.rejected)
    log.info("%d scenes, %d grasps", len(found.scenes), len(found.grasps))


if __name__ == "__main__":
    run_job(run)

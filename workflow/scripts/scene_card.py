"""scene-card: a readable description of a set of labelled scenes."""

import logging
from pathlib import Path

from egad.learning import remove_leftovers
from egad.learning.scenes import SceneParameters, describe_set, read_plan
from egad_workflow.job import run_job

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
    """Write the card of a set of scenes, and remove leftovers of an earlier, larger set."""
    remove_leftovers(folder, ["scenes", "grasps"], shards)
    plan = read_plan(settings, objects, scales, convex_parts, evaluation, ancestry)
    title = f"Labelled scenes of {dataset} for {gripper}"
    found = describe_set(folder, settings, title, len(plan.scenes), plan.splits, plan.rejected)
    log.info("%d scenes, %d grasps", len(found.scenes), len(found.grasps))


if __name__ == "__main__":
    run_job(run)

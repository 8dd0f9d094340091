"""scenes: packed and piled objects of a dataset with depth images and labelled grasps."""

import logging
from pathlib import Path

from egad._util.progress import phase, progress
from egad.config.stages import MakeScenes
from egad.learning.scenes import make_scene, scenes_of_shard, set_notes, write_shard
from egad.workflow.job import run_job
from egad.workflow.scene_inputs import StoredModels, read_plan

log = logging.getLogger(__name__)


def run(
    settings: MakeScenes,
    gripper: str,
    objects: Path,
    scales: Path,
    meshes: Path,
    convex_parts: Path,
    shard: tuple[int, int],
    out: Path,
    grasps: Path,
    evaluation: Path | None = None,
    ancestry: Path | None = None,
) -> None:
    """Make the scenes of a shard, with their images and labelled grasps.

    Without ancestry, each object is a family of its own.
    """
    number, total = shard
    plan = read_plan(settings, objects, scales, convex_parts, evaluation, ancestry)
    mine = scenes_of_shard(plan.scenes, number, total, settings.scenes.scenes)
    phase("reading objects")
    models = StoredModels(settings, objects, meshes, convex_parts)
    made = []
    for planned in progress(mine, "making scenes", len(mine)):
        found = make_scene(planned, models.of(planned), settings)
        if found is None:
            log.warning("scene %d is left out: the simulation went wrong", planned.round.number)
        else:
            made.append(found)
    about = set_notes(settings, plan.usable, gripper)
    write_shard(made, number, total, about, out, grasps)
    log.info("%d of %d scenes", len(made), len(mine))


if __name__ == "__main__":
    run_job(run)

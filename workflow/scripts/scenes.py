"""scenes: packed and piled objects of a dataset with depth images and labelled grasps."""

import logging
from functools import lru_cache
from pathlib import Path

from egad._util.progress import phase, progress
from egad.io import read_mesh
from egad.learning.images import model_at_size
from egad.learning.scenes import (
    MakeScenes,
    PlannedScene,
    make_scene,
    read_plan,
    scenes_of_shard,
    set_notes,
    write_shard,
)
from egad.sim import Model, read_parts
from egad.tables import parquet
from egad.tables.evaluation import CONVEX_PARTS
from egad.tables.objects import OBJECTS
from egad_workflow.job import run_job

log = logging.getLogger(__name__)
KEPT = 200  # objects kept in memory


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
    """Make the scenes of a shard, with their images and labelled grasps."""
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


class StoredModels:
    """The objects of a dataset as they are simulated, loaded on demand."""

    def __init__(
        self, settings: MakeScenes, objects: Path, meshes: Path, convex_parts: Path
    ) -> None:
        """Find the objects of a dataset, their scaled meshes and their convex parts."""
        table = parquet.read(objects, OBJECTS)
        self._labels = dict(zip(table["id"], table["label"], strict=True))
        self._parts = dict(iter(parquet.read(convex_parts, CONVEX_PARTS).groupby("label")))
        self._density, self._meshes = settings.material.density, meshes
        self._known = lru_cache(KEPT)(self._read)

    def of(self, planned: PlannedScene) -> dict[str, Model]:
        """The objects of a scene, by id."""
        return {name: self._known(name) for name in planned.round.ids}

    def _read(self, name: str) -> Model:
        label = self._labels[name]
        mesh = read_mesh(self._meshes / f"{label}.obj", "m")
        return model_at_size(mesh, read_parts(self._parts[label]), 1.0, self._density)


if __name__ == "__main__":
    run_job(run)

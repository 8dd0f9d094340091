"""Inputs of the labelled scenes of a dataset: the plan and the objects, read from its tables."""

from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import pandas as pd

from egad.config.stages import MakeScenes
from egad.errors import UserError
from egad.evolution import Lineage
from egad.geometry import read_parts
from egad.io import read_mesh
from egad.learning.images import model_at_size
from egad.learning.scenes import (
    PlannedScene,
    SceneParameters,
    Splits,
    planned_scenes,
    split_objects,
)
from egad.sim import Model
from egad.tables import parquet
from egad.tables.evaluation import CONVEX_PARTS
from egad.tables.evolution import LINEAGE
from egad.tables.objects import OBJECTS, REJECTED
from egad.workflow.shards import rejection

KEPT = 200  # objects kept in memory


class ScenePlan(NamedTuple):
    """The planned scenes of a dataset."""

    scenes: list[PlannedScene]
    splits: Splits  # how the objects are split
    rejected: pd.DataFrame  # objects that cannot be simulated, columns of `tables.objects.REJECTED`
    usable: dict[str, str]  # the split of each object that can be simulated


def read_plan(
    settings: SceneParameters,
    objects: Path,
    scales: Path,
    convex_parts: Path,
    evaluation: Path | None,
    ancestry: Path | None,
) -> ScenePlan:
    """Plan the scenes of a dataset; an evaluation set is held out, with ancestors if known.

    Raises `UserError` if all objects are held out, or none can be simulated.
    """
    table = parquet.read(objects, OBJECTS)[["id", "label"]]
    lineage = Lineage(parquet.read(ancestry, LINEAGE)) if ancestry else None
    held_out = parquet.distinct(evaluation, "id") if evaluation else set()
    splits = split_objects(table["id"].tolist(), lineage, held_out, settings)
    if len(table) and not splits.split_of:
        raise UserError(
            f"{objects}: all {len(table)} objects are in the evaluation set, or are parents or "
            "children of objects in it; set scenes.hold_out: false"
        )
    scaled, simulated = parquet.distinct(scales, "label"), parquet.distinct(convex_parts, "label")
    reasons = {
        row["id"]: "it could not be scaled to the gripper"
        if row["label"] not in scaled
        else "it has no convex parts for the simulation"
        for row in parquet.records(table)
        if row["label"] not in scaled & simulated
    }
    usable = {name: split for name, split in splits.split_of.items() if name not in reasons}
    if not usable:
        raise UserError(f"{objects}: no object of the dataset can be simulated in scenes")
    rows = [rejection(name, "scenes", reason) for name, reason in sorted(reasons.items())]
    return ScenePlan(
        planned_scenes(usable, settings), splits, pd.DataFrame(rows, columns=REJECTED.names), usable
    )


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

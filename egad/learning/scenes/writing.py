"""Labelled scenes as files: shards that belong together, and their description."""

import json
from collections.abc import Mapping, Sequence
from hashlib import sha256
from pathlib import Path
from typing import Any

import pandas as pd

from egad._util.files import atomic_output, write_text
from egad.errors import UserError
from egad.learning.scenes.cards import GRASP_COLUMNS, PICTURE, SCENE_COLUMNS, SceneSet, card
from egad.learning.scenes.making import MadeScene
from egad.learning.scenes.parameters import SceneParameters
from egad.learning.scenes.pictures import scene_png
from egad.learning.scenes.planning import Splits
from egad.learning.scenes.reading import MAKERS, TABLES, SceneDataset
from egad.learning.shards import rows_of, shard_files
from egad.tables import parquet
from egad.tables.objects import REJECTED
from egad.tables.scenes import SCENE_GRASPS, SCENES


def write_shard(
    made: Sequence[MadeScene],
    shard: int,
    shards: int,
    about: Mapping[str, Any],
    scenes: Path,
    grasps: Path,
) -> None:
    """Write the scenes of a shard, each readable by itself, and their grasps."""
    notes = {"shard": shard, "shards": shards, **about}
    parquet.write(pd.DataFrame([each.scene for each in made]), SCENES, scenes, notes, group=1)
    tables = [each.grasps for each in made if len(each.grasps)]
    table = pd.concat(tables) if tables else parquet.empty(SCENE_GRASPS)
    parquet.write(table, SCENE_GRASPS, grasps, notes)


def set_notes(
    settings: SceneParameters, split_of: Mapping[str, str], gripper: str
) -> dict[str, Any]:
    """What the shards of a set note: a digest of settings and objects, and the gripper."""
    values = settings.model_dump(mode="json")
    text = json.dumps([values, split_of], sort_keys=True)
    key = sha256(text.encode()).hexdigest()[:16]
    return {"set": key, "gripper": gripper, "hand": values["gripper"]}


def describe_set(
    folder: Path,
    settings: SceneParameters,
    title: str,
    planned: int,
    splits: Splits,
    rejected: pd.DataFrame,
) -> SceneSet:
    """Write `card.md`, `scene.png` and `rejected.parquet` beside the shards of a whole set."""
    pairs = shard_files(folder, TABLES, MAKERS)
    scenes = rows_of([first for first, _ in pairs], SCENES, SCENE_COLUMNS)
    grasps = rows_of([second for _, second in pairs], SCENE_GRASPS, GRASP_COLUMNS)
    if scenes.empty:
        raise UserError(f"{folder}: no scene could be made, as the simulation went wrong in all")
    found = SceneSet(scenes, grasps, planned, splits, rejected)
    dataset = SceneDataset([folder])
    held = dataset.index["positive"]
    order = [(not n, noise != "none") for n, noise in zip(held, scenes["noise"], strict=True)]
    shown = min(range(len(order)), key=order.__getitem__)
    with atomic_output(folder / PICTURE) as path:
        path.write_bytes(scene_png(dataset.scene(shown), settings.gripper))
    parquet.write(rejected, REJECTED, folder / "rejected.parquet")
    write_text(folder / "card.md", card(settings, title, found))
    return found

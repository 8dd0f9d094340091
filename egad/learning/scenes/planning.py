"""Which objects of which split are in which scene (ours)."""

from collections.abc import Collection, Container, Iterable, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from egad.bench import Round, SceneKind, draw_objects
from egad.errors import UserError
from egad.evalset import families, split_by_family, with_parents_and_children
from egad.evolution import Lineage
from egad.learning.images import SPLITS
from egad.learning.scenes.parameters import MAX_OBJECTS, SceneParameters
from egad.random import entropy, generator
from egad.tables import parquet
from egad.tables.evolution import LINEAGE
from egad.tables.objects import OBJECTS, REJECTED, rejection

SHARD = 50  # scenes, about: the number of shards follows from the settings alone


class Splits(NamedTuple):
    """The split of each usable object, by id; families are 0 without ancestors."""

    split_of: dict[str, str]
    families: int
    held_out: int


class PlannedScene(NamedTuple):
    """A scene to be made, and its split: `train`, `validation` or `test`."""

    round: Round
    split: str


def shard_count(scenes: int) -> int:
    """The number of shards of a set, given its number of scenes."""
    return -(-scenes // SHARD)


def split_objects(
    ids: Collection[str],
    lineage: Lineage | None,
    hold_out: Collection[str],
    settings: SceneParameters,
) -> Splits:
    """Split objects such that no family is in two splits, the largest ones for training.

    Without ancestors each object is a family. Those to hold out, and parents and children of these,
    are in no scene.
    """
    known = lineage if lineage and all(name in lineage for name in ids) else None
    held = set(ids) if known is None else known
    named = {name for name in hold_out if name in held}
    out = with_parents_and_children(named, known) & set(ids)
    family_of = families(sorted(set(ids) - out), known)
    scenes, seed = settings.scenes, settings.seed
    others = scenes.validation + scenes.test
    first = split_by_family(family_of, (), others, seed)
    rest = {name: family_of[name] for name, split in first.items() if split == "validation"}
    second = split_by_family(rest, (), scenes.test / others if others else 0, seed)
    names = {"train": "validation", "validation": "test"}
    split_of = first | {name: names[split] for name, split in second.items()}
    return Splits(split_of, len(set(family_of.values())) if known else 0, len(out))


def planned_scenes(split_of: Mapping[str, str], settings: SceneParameters) -> list[PlannedScene]:
    """All scenes in order, kinds spread evenly; UserError if there are none."""
    scenes = settings.scenes
    test, validation = (round(p * scenes.scenes) for p in (scenes.test, scenes.validation))
    ends = np.cumsum([0, scenes.scenes - test - validation, validation, test]).tolist()
    members = {
        name: sorted(each for each, split in split_of.items() if split == name) for name in SPLITS
    }
    plan = [
        PlannedScene(_planned(number, members[split], settings), split)
        for split, (first, end) in zip(SPLITS, pairwise(ends), strict=True)
        for number in range(first, end)
        if members[split]
    ]
    if not plan:
        raise UserError(
            f"{scenes.scenes} scenes of {len(split_of)} objects: no split has both; ask for more "
            "scenes, or for smaller fractions for validation and test"
        )
    return plan


def with_objects(plan: Iterable[PlannedScene], ids: Container[str]) -> list[PlannedScene]:
    """The scenes that have some of the objects, without their other objects."""
    found = []
    for planned in plan:
        this = planned.round
        kept = [pair for pair in zip(this.ids, this.factors, strict=True) if pair[0] in ids]
        if kept:
            names, factors = zip(*kept, strict=True)
            found.append(planned._replace(round=this._replace(ids=names, factors=factors)))
    return found


def scenes_of_shard(
    plan: Sequence[PlannedScene], shard: int, shards: int, scenes: int
) -> list[PlannedScene]:
    """The scenes of a shard, by number, shards and scenes of the whole set."""
    return [each for each in plan if each.round.number * shards // scenes == shard]


def _planned(number: int, ids: Sequence[str], settings: SceneParameters) -> Round:
    scenes = settings.scenes
    rng = generator(settings.seed, "training scene", number)
    share = scenes.pile
    kind: SceneKind = "pile" if int((number + 1) * share) > int(number * share) else "packed"
    count = min(1 + int(rng.poisson(scenes.objects - 1)), MAX_OBJECTS)
    noise = scenes.noise[rng.integers(len(scenes.noise))]
    chosen, factors = draw_objects(ids, kind, count, scenes.protocol, rng)
    seed = entropy(settings.seed, "training round", number)
    return Round(kind, noise, number, seed, chosen, factors)


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
    """Plan the scenes of a dataset; an evaluation set is held out, with ancestors if known."""
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

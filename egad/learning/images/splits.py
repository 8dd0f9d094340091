"""Splits by object, and how many images each object gets (ours)."""

from collections.abc import Collection
from itertools import count
from typing import NamedTuple

import numpy as np
import pandas as pd

from egad.bench import SceneKind
from egad.errors import UserError
from egad.learning.images.parameters import Render
from egad.random import entropy, generator

SPLITS = ("train", "validation", "test")
SHARD = 500  # images, about: the number of shards follows from the settings alone
VIEWS = 4  # images of a scene of several objects, at most


def check_splits(index: pd.DataFrame, where: object) -> None:
    """Raise UserError if an object is in two splits; `where` says whose rows these are."""
    if unknown := set(index["split"]) - set(SPLITS):
        raise UserError(f"{where}: the split {unknown.pop()!r} is none of {', '.join(SPLITS)}")
    shared = index.explode("objects").groupby("objects")["split"].nunique() > 1
    if shared.any():
        raise UserError(f"{where}: the object {shared.idxmax()} is in more than one split")


class Share(NamedTuple):
    """An object, or a scene of several `members`, and its images, from number `first` on."""

    id: str
    label: str
    split: str
    first: int
    images: int
    scene: SceneKind
    members: tuple[str, ...]


def shares(
    objects: pd.DataFrame, evaluation: Collection[str], settings: Render, seed: int
) -> list[Share]:
    """The images of all objects (columns id, label, complexity), in the order of their numbers.

    Any run of images is a fair sample; scenes of several objects come last. All objects are split
    before the wanted ones are taken, so an object always stays in its split.
    """
    split = split_of(objects["id"].tolist(), evaluation, settings, seed)
    wanted = _drawn(objects[_within(objects, settings.complexity)], settings.subset, seed)
    chosen = sorted(
        zip(wanted["id"], wanted["label"], strict=True),
        key=lambda names: entropy(seed, "image order", names[0]),
    )
    members = {name: [label for i, label in chosen if split[i] == name] for name in SPLITS}
    kinds = _kinds(settings)
    counts = {name: iter(evenly(kinds[name]["single"], len(members[name]))) for name in SPLITS}
    found = [
        Share(
            object_id,
            label,
            split[object_id],
            0,
            next(counts[split[object_id]]),
            "single",
            (label,),
        )
        for object_id, label in chosen
    ]
    for kind in ("packed", "pile"):
        for name in SPLITS:
            found += _scenes(kind, name, members[name], kinds[name][kind], settings.objects, seed)
    firsts = np.cumsum([0, *(share.images for share in found)]).tolist()
    return [share._replace(first=first) for share, first in zip(found, firsts, strict=False)]


def _scenes(
    kind: SceneKind, split: str, labels: list[str], images: int, objects: int, seed: int
) -> list[Share]:
    """Scenes of several objects of a split, each with a few images."""
    counts = evenly(images, -(-images // VIEWS)) if labels else []
    names = (f"{kind}-{split}-{number}" for number in count())
    found = []
    for name, shown in zip(names, counts, strict=False):
        order = generator(seed, "scene", name).permutation(len(labels))[:objects]
        members = tuple(labels[number] for number in order)
        found.append(Share(name, name, split, 0, shown, kind, members))
    return found


def shard_count(images: int) -> int:
    """The number of shards of a set, given its number of images."""
    return -(-images // SHARD)


def split_of(
    ids: Collection[str], evaluation: Collection[str], settings: Render, seed: int
) -> dict[str, str]:
    """The split of each object: `test` first, with the evaluation set, then `validation`."""
    held_out = set(evaluation)
    order = sorted(ids, key=lambda name: (name not in held_out, entropy(seed, "split", name)))
    known = sum(name in held_out for name in order)
    test = max(_part(settings.test, len(order)), known)
    validation = min(_part(settings.validation, len(order)), max(len(order) - test - 1, 0))
    names = ["test"] * test + ["validation"] * validation
    names += ["train"] * (len(order) - len(names))
    return dict(zip(order, names, strict=True))


def evenly(total: int, parts: int) -> list[int]:
    """A number cut into whole parts that differ by one at most, spread evenly; none if no parts."""
    return [(i + 1) * total // parts - i * total // parts for i in range(parts)]


def _part(fraction: float, count: int) -> int:
    """A fraction of `count` objects, rounded; at least one of three or more, unless it is 0."""
    return max(round(fraction * count), int(fraction > 0 and count > 2))


def _kinds(settings: Render) -> dict[str, dict[SceneKind, int]]:
    """The number of images of each split and kind of scene."""
    test, validation = (round(p * settings.images) for p in (settings.test, settings.validation))
    budgets = {"train": settings.images - test - validation, "validation": validation, "test": test}
    found: dict[str, dict[SceneKind, int]] = {}
    for name, images in budgets.items():
        packed, pile = (round(part * images) for part in (settings.packed, settings.pile))
        pile = min(pile, images - packed)
        found[name] = {"single": images - packed - pile, "packed": packed, "pile": pile}
    return found


def _drawn(objects: pd.DataFrame, part: float, seed: int) -> pd.DataFrame:
    """A random part of some objects, at least one if there are any."""
    order = sorted(objects["id"], key=lambda name: entropy(seed, "part", name))
    return objects[objects["id"].isin(order[: max(round(part * len(order)), 1)])]


def _within(objects: pd.DataFrame, wanted: tuple[float, float]) -> "pd.Series[bool]":
    """Which objects have a rank in complexity, 0 to 1, within a range."""
    order = objects.sort_values(["complexity", "id"]).index
    ranks = pd.Series((np.arange(len(order)) + 0.5) / max(len(order), 1), index=order)
    low, high = wanted
    inside = (ranks >= low) & (ranks < high)
    return inside.reindex(objects.index)

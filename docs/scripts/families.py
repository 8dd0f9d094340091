"""How well families separate similar released objects: `python docs/scripts/families.py`.

Families are cut from the lines of first parents: at their founders, or some generations later. For
each cut, 200 random splits put whole families aside for validation until they have about a tenth
of the objects. The table has the fraction of these whose voxels overlap those of an object for
training by more than 0.9 (intersection over union, as they lie in the cube of the network). The
last lines give the same for the splits of the dataset release.
"""

from collections import Counter
from itertools import chain

import numpy as np
import pandas as pd
from numpy.typing import NDArray

import egad
from egad.data import evaluation_set
from egad.evalset import families as families_of
from egad.evalset import split_by_family, with_parents_and_children
from egad.random import generator
from egad_workflow.settings import Settings

PART, SPLITS, TWIN = 0.1, 200, 0.9
CUTS = (0, 2, 7)

Labels = NDArray[np.str_]
Matrix = NDArray[np.float32]


def overlaps(objects: egad.Dataset) -> Matrix:
    """Intersection over union of the voxels of all pairs of objects, (n, n); 0 on the diagonal."""
    voxels = np.stack([each.voxels.ravel() for each in objects]).astype(np.float32)
    common, sizes = voxels @ voxels.T, voxels.sum(axis=1)
    found = common / (sizes[:, None] + sizes - common)
    np.fill_diagonal(found, 0)
    return np.asarray(found)


def twins(families: Labels, overlap: Matrix) -> float:
    """Mean fraction of the validation objects that nearly equal an object for training."""
    names, sizes = np.unique(families, return_counts=True)
    found = []
    for split in range(SPLITS):
        order = generator(0, "families", split).permutation(len(names))
        chosen: list[int] = []
        for family in order:
            if sizes[[*chosen, family]].sum() <= 1.1 * PART * len(families):
                chosen.append(family)
            if sizes[chosen].sum() >= 0.95 * PART * len(families):
                break
        held_out = np.isin(families, names[chosen])
        found.append((overlap[held_out][:, ~held_out].max(axis=1) > TWIN).mean())
    return float(np.mean(found))


def print_release_splits(ids: list[str], lineage: egad.Lineage, overlap: Matrix) -> None:
    """Print how many objects of each part of the release nearly equal one for training."""
    settings, chosen = Settings(), list(pd.read_csv(evaluation_set())["id"])
    test = with_parents_and_children(chosen, lineage)
    validation = settings.release.validation
    split_of = split_by_family(families_of(ids, lineage), test, validation, settings.seed)
    split = np.array([split_of[name] for name in ids])
    parts = {name: split == name for name in ("train", "validation", "test")}
    for name, part in {**parts, "evaluation set": np.isin(ids, chosen)}.items():
        rate = (overlap[part][:, parts["train"]].max(axis=1) > TWIN).mean()
        print(f"{name}: {part.sum()} objects, {rate:.1%} nearly equal one for training")


def main() -> None:
    """Print the sizes of the families, how alike relatives are, and a row for each split."""
    objects = egad.load("released")
    lineage, ids = objects.lineage, [each.id for each in objects]
    lines = {name: lineage.line(name)[::-1] for name in ids}
    overlap, place = overlaps(objects), {name: i for i, name in enumerate(ids)}
    founders = [lineage.founders(name) for name in ids]
    shared = max(Counter(chain.from_iterable(founders)).values())
    pairs = [(name, line[-2]) for name, line in lines.items() if len(line) > 1]
    alike = [overlap[place[child], place[parent]] for child, parent in pairs if parent in place]
    print(f"founders: median {np.median([*map(len, founders)]):.0f}, one of {shared} objects")
    nearest = np.median(overlap.max(axis=1))
    print(f"median overlap with the first parent {np.median(alike):.2f}, with any {nearest:.2f}")
    print("| cut | families | largest | nearly equal to an object for training |")
    print("| --- " * 4 + "|")
    splits = {f"generation {cut}": [lines[name][: cut + 1][-1] for name in ids] for cut in CUTS}
    for name, families in {"random": ids, **splits}.items():
        sizes = sorted(np.unique(families, return_counts=True)[1], reverse=True)[:4]
        rate = twins(np.array(families), overlap)
        print(f"| {name} | {len(set(families))} | {', '.join(map(str, sizes))} | {rate:.1%} |")
    print_release_splits(ids, lineage, overlap)


if __name__ == "__main__":
    main()

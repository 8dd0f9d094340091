"""Twins in training and test: `python twins.py results/egad GRIPPER`.

Compares each object of the evaluation set with each object that a training set learns from, by the
intersection over union of their voxels, as the two evolved, neither turned nor moved.
"""

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from study import Network, Study, read_study, settings_for

from egad.config.stages import select
from egad.learning.images import RenderParameters, shares
from egad.tables import parquet
from egad.tables.evaluation import EVAL49
from egad.tables.evolution import ARCHIVE
from egad.tables.grasping import SCALES
from egad.tables.objects import OBJECTS

CONFIG = Path(__file__).with_name("study.yaml")
TWIN = 0.9


def main(folder: Path, gripper: str, config: Path = CONFIG) -> None:
    """Print a row for each set of the configuration that is taken from this dataset."""
    study = read_study(config)
    archive = parquet.read(folder / "archive.parquet", ARCHIVE)
    bits = [np.unpackbits(np.frombuffer(data, np.uint8)) for data in archive["voxels"]]
    solids = dict(zip(archive["id"], bits, strict=True))
    tried = np.array([solids[name] for name in parquet.read(folder / "eval49.parquet", EVAL49).id])
    print(f"| set | objects learnt from | median | above {TWIN}, of {len(tried)} |")
    print("| --- | --- | --- | --- |")
    for name in study.plan.sets:
        if study.plan.training_sets[name].dataset == folder.name:
            known = np.array([solids[each] for each in learnt(study, name, folder, gripper)])
            best = overlaps(tried, known).max(axis=1)
            print(f"| `{name}` | {len(known)} | {np.median(best):.2f} | {(best > TWIN).sum()} |")


def learnt(study: Study, name: str, folder: Path, gripper: str) -> list[str]:
    """Ids of the objects that the networks of a training set learn from."""
    wanted = select(settings_for(study, Network(name, 0)), RenderParameters, gripper)
    evaluation = parquet.read(folder / "eval49.parquet", EVAL49)
    held_out = set(evaluation["id"]) if wanted.render.hold_out else set()
    objects = parquet.read(folder / "objects.parquet", OBJECTS)
    scales = parquet.read(folder / "rescaled" / gripper / "scales.parquet", SCALES)
    scaled = objects[objects["label"].isin(scales["label"])]
    planned = shares(scaled, held_out, wanted.render, wanted.seed)
    return [share.id for share in planned if share.images and share.split == "train"]


def overlaps(some: NDArray[np.uint8], others: NDArray[np.uint8]) -> NDArray[np.float64]:
    """Intersection over union of solids (n, voxels) and (m, voxels): (n, m)."""
    one, other = some.astype(np.float64), others.astype(np.float64)
    both = one @ other.T
    found: NDArray[np.float64] = both / (one.sum(axis=1)[:, None] + other.sum(axis=1) - both)
    return found


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2])

"""Twins in training and test: `python experiments/twins.py results/egad GRIPPER`.

Of each object of the evaluation set, and each object that a training set learns from, the voxels
that both fill / those that either fills, as the two evolved, neither turned nor moved.
"""

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from egad.perception import RenderParameters
from egad.pipeline.cli.common import settings_in
from egad.pipeline.config import Settings
from egad.pipeline.config.stage_settings import select
from egad.pipeline.config.training_study import Network, settings_for
from egad.pipeline.stages.render import planned
from egad.tables import parquet
from egad.tables.evaluation import EVAL49
from egad.tables.evolution import ARCHIVE

CONFIG = Path(__file__).parents[1] / "config/training_study.yaml"
TWIN = 0.9


def main(folder: Path, gripper: str, config: Path = CONFIG) -> None:
    """Print a row for each set of the configuration that is taken from this dataset."""
    settings = settings_in(config)
    archive = parquet.read(folder / "archive.parquet", ARCHIVE)
    bits = [np.unpackbits(np.frombuffer(data, np.uint8)) for data in archive["voxels"]]
    solids = dict(zip(archive["id"], bits, strict=True))
    tried = np.array([solids[name] for name in parquet.read(folder / "eval49.parquet", EVAL49).id])
    print(f"| set | objects learnt from | median | above {TWIN}, of {len(tried)} |")
    print("| --- | --- | --- | --- |")
    for name in settings.training_study.sets:
        if settings.training_sets[name].dataset == folder.name:
            known = np.array([solids[each] for each in learnt(settings, name, folder, gripper)])
            best = overlaps(tried, known).max(axis=1)
            print(f"| `{name}` | {len(known)} | {np.median(best):.2f} | {(best > TWIN).sum()} |")


def learnt(settings: Settings, name: str, folder: Path, gripper: str) -> list[str]:
    """Ids of the objects that the networks of a training set learn from."""
    wanted = select(settings_for(settings, Network(name, 0)), RenderParameters, gripper)
    held_out = folder / "eval49.parquet" if wanted.render.hold_out else None
    shares = planned(wanted, folder / "objects.parquet", folder / "rescaled" / gripper, held_out)
    return [share.id for share in shares if share.images and share.split == "train"]


def overlaps(some: NDArray[np.uint8], others: NDArray[np.uint8]) -> NDArray[np.float64]:
    """Intersection over union of solids (n, voxels) and (m, voxels): (n, m)."""
    one, other = some.astype(np.float64), others.astype(np.float64)
    both = one @ other.T
    found: NDArray[np.float64] = both / (one.sum(axis=1)[:, None] + other.sum(axis=1) - both)
    return found


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2])

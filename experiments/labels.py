"""What networks learn from: `python experiments/labels.py results/training_study/images`."""

import sys
from pathlib import Path

import numpy as np
import pandas as pd

from egad.learning import PositiveFilter, positive
from egad.perception import files
from egad.pipeline.config import Training
from egad.tables import parquet

COLUMNS = ["id", "split", "focal", "opening", "depth_center", "quality", "collision_free"]
NARROW = 0.05  # metres
RULE = PositiveFilter(Training().quality, Training().breadth)


def main(images: Path) -> None:
    """Print objects, images and positive grasps that each training set learns from."""
    print("| set | objects | images | with a positive grasp | positive grasps | below 50 mm, % |")
    print("| --- " * 6 + "|")
    for folder in sorted(path for path in images.iterdir() if path.is_dir()):
        batches = (rows for path in files(folder) for rows in parquet.batches(path, COLUMNS))
        learnt = pd.concat(rows[rows["split"] == "train"] for rows in batches)
        widths = [openings(row) for row in learnt.itertuples()]
        every = np.concatenate(widths)
        some = sum(len(each) > 0 for each in widths)
        numbers = [learnt["id"].nunique(), len(learnt), some, len(every)]
        cells = " | ".join(f"{number:,}" for number in numbers)
        print(f"| `{folder.name}` | {cells} | {100 * np.mean(every < NARROW):.0f} |")


def openings(row: tuple) -> np.ndarray:
    """Those of the positive grasps of an image, metres (n,)."""
    good = positive(row._asdict(), RULE)
    return (np.asarray(row.opening) * np.asarray(row.depth_center) / row.focal)[good]


if __name__ == "__main__":
    main(Path(sys.argv[1]))

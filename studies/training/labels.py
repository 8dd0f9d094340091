"""What networks learn from: `python labels.py results/training_study/images`."""

import sys
from pathlib import Path

import numpy as np
import pandas as pd

from egad._util.markdown import table
from egad.learning import Training
from egad.learning.images import COLUMNS, NARROW, files, summary
from egad.tables import parquet

COUNTED = ["objects", "images", "without_good", "good"]
HEAD = ["set", "objects", "images", "without a good grasp", "good grasps", "below 50 mm, %"]


def main(images: Path) -> None:
    """Print objects, images and good grasps that each training set learns from."""
    lines = []
    for folder in sorted(path for path in images.iterdir() if path.is_dir()):
        batches = [rows for path in files(folder) for rows in parquet.batches(path, COLUMNS)]
        rows = pd.concat(batches)
        found = summary(rows[rows["split"] == "train"], Training().quality)
        counts = list(map(int, found.counts.loc[["all"], COUNTED].to_numpy()[0]))
        lines.append((f"`{folder.name}`", *counts, f"{100 * np.mean(found.openings < NARROW):.0f}"))
    print(table(HEAD, lines))


if __name__ == "__main__":
    main(Path(sys.argv[1]))

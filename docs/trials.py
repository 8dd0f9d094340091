"""The picture of docs/trials.md: `python docs/trials.py results/D G P`.

For each outcome that came to a grasp, the first attempt that ended so is repeated; a row shows
frames of it, evenly spaced from shortly before the hand comes to the end.
"""

import sys
from pathlib import Path

import numpy as np
import pandas as pd
from PIL import Image, ImageDraw

from egad.files import replacing
from egad.settings import Settings
from egad.stage_settings import SimulatedTrials, select
from egad.stages.replay import repeated
from egad.tables import parquet
from egad.tables.evaluation import TRIALS

HERE = Path(__file__).parent
OUTCOMES = ("success", "collided", "missed", "slipped_closing", "slipped_lifting", "dropped")
FRAMES = 6
WIDTH, HEIGHT, TEXT = 180, 200, 16
SETTLING = 0.4  # of the film is left out


def main(folder: Path, gripper: str, policy: str) -> None:
    """Write the picture beside this file."""
    settings = select(Settings(), SimulatedTrials, gripper, policy)
    path = folder / "trials" / gripper / f"{policy}.parquet"
    trials = parquet.read(path, TRIALS)
    shown = [trials[trials["outcome"] == outcome].head(1) for outcome in OUTCOMES]
    rows = parquet.records(pd.concat(shown))
    sheet = Image.new("RGB", (FRAMES * WIDTH, len(rows) * (HEIGHT + TEXT)), "white")
    pen = ImageDraw.Draw(sheet)
    for place, row in enumerate(rows):
        top = place * (HEIGHT + TEXT)
        pen.text(
            (4, top + 2), f"{row['outcome']}: {row['label']}, attempt {row['attempt']}", "black"
        )
        _, frames = repeated(settings, row, folder / "bundle" / gripper)
        for column, number in enumerate(chosen(len(frames))):
            small = Image.fromarray(frames[number]).resize((WIDTH, HEIGHT))
            sheet.paste(small, (column * WIDTH, top + TEXT))
    with replacing(HERE / "trials.png") as out:
        sheet.quantize(64).save(out, "png", optimize=True)


def chosen(count: int) -> list[int]:
    """Numbers of the frames that are shown."""
    found: list[int] = np.linspace(SETTLING * count, count - 1, FRAMES).astype(int).tolist()
    return found


if __name__ == "__main__":
    main(Path(sys.argv[1]), *sys.argv[2:])

"""The picture of docs/trials.md: `python experiments/trials.py results/D G P...`.

For each outcome that came to a grasp, the first attempt of these detectors that ended so is
repeated; a row shows frames of it, evenly spaced from when the hand comes to the end.
"""

import sys
from pathlib import Path

import numpy as np
import pandas as pd
from PIL import Image, ImageDraw

from egad._util.files import atomic_output
from egad.outcomes import EXECUTION
from egad.pipeline.config import Settings
from egad.pipeline.config.stage_settings import select
from egad.pipeline.stages.replay import repeat_attempt
from egad.pipeline.stages.simulate import SimulatedTrials
from egad.sim import Pixels
from egad.tables import parquet
from egad.tables.evaluation import TRIALS

DOCS = Path(__file__).parents[1] / "docs"
FRAMES = 6
WIDTH, HEIGHT, TEXT = 180, 200, 16
HAND = (120, 205)  # its shades of grey; nothing else is as dark and without color


def main(folder: Path, gripper: str, *detectors: str) -> None:
    """Write the picture beside this file."""
    settings = select(Settings(), SimulatedTrials, gripper)
    tables = [folder / "trials" / gripper / f"{detector}.parquet" for detector in detectors]
    trials = pd.concat(parquet.read(path, TRIALS) for path in tables)
    shown = [trials[trials["outcome"] == outcome].head(1) for outcome in EXECUTION]
    rows = parquet.records(pd.concat(shown))
    sheet = Image.new("RGB", (FRAMES * WIDTH, len(rows) * (HEIGHT + TEXT)), "white")
    pen = ImageDraw.Draw(sheet)
    for place, row in enumerate(rows):
        top = place * (HEIGHT + TEXT)
        pen.text(
            (4, top + 2), f"{row['outcome']}: {row['label']}, attempt {row['attempt']}", "black"
        )
        _, frames = repeat_attempt(settings, row, folder / "bundle" / gripper)
        for column, number in enumerate(chosen(frames)):
            small = Image.fromarray(frames[number]).resize((WIDTH, HEIGHT))
            sheet.paste(small, (column * WIDTH, top + TEXT))
    with atomic_output(DOCS / "trials.png") as out:
        sheet.quantize(64).save(out, "png", optimize=True)


def chosen(frames: list[Pixels]) -> list[int]:
    """Numbers of the frames that are shown."""
    first = next(number for number, frame in enumerate(frames) if shows_hand(frame))
    found: list[int] = np.linspace(first, len(frames) - 1, FRAMES).astype(int).tolist()
    return found


def shows_hand(frame: Pixels) -> bool:
    """Whether there is much grey."""
    low, high = frame.min(axis=2), frame.max(axis=2)
    grey = (high - low < 8) & (low > HAND[0]) & (high < HAND[1])
    return bool(grey.mean() > 0.02)


if __name__ == "__main__":
    main(Path(sys.argv[1]), *sys.argv[2:])

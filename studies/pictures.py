"""Sheets of pictures of attempts: which attempts, which frames of their films, and the sheet."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from PIL import Image, ImageDraw

from egad._util.arrays import RgbImage
from egad._util.files import atomic_output
from egad.sim import ROBOT_COLOR

WIDTH, HEIGHT, TEXT = 180, 200, 16


def typical(attempts: pd.DataFrame, name: str, share: float) -> pd.DataFrame:
    """One failed attempt of each frequent outcome, the most frequent outcome first.

    It is the first attempt at the object with most of that outcome.

    Args:
        attempts: With `success`, `outcome`, and `width`, which is missing without a grasp.
        name: Column of the names of the objects.
        share: An outcome is frequent if more than this share of the failed attempts have it.
    """
    failed = attempts[~attempts["success"] & attempts["width"].notna()]
    shown = [failed.head(0)]
    for outcome, count in failed["outcome"].value_counts().items():
        own = failed[failed["outcome"] == outcome]
        if count > share * len(failed):
            shown.append(own[own[name] == own[name].value_counts().index[0]].head(1))
    return pd.concat(shown)


def chosen(frames: Sequence[RgbImage], count: int) -> list[RgbImage]:
    """Frames at equal distances, from the first that shows the hand to the last."""
    shown = [number for number, frame in enumerate(frames) if shows_hand(frame)]
    return [frames[number] for number in np.linspace(shown[0], shown[-1], count).astype(int)]


def shows_hand(frame: RgbImage) -> bool:
    """Whether many pixels have the color of the robot, in any light."""
    color = frame / np.maximum(frame.max(axis=2, keepdims=True), 1)
    robot = np.array(ROBOT_COLOR) / max(ROBOT_COLOR)
    return bool((np.abs(color - robot).max(axis=2) < 0.02).mean() > 0.02)


def save_sheet(rows: Sequence[tuple[str, Sequence[RgbImage]]], out: Path, colors: int) -> None:
    """Write a PNG of rows of pictures, each below its title."""
    width = WIDTH * max(len(pictures) for _, pictures in rows)
    sheet = Image.new("RGB", (width, len(rows) * (HEIGHT + TEXT)), "white")
    for place, (title, pictures) in enumerate(rows):
        top = place * (HEIGHT + TEXT)
        ImageDraw.Draw(sheet).text((4, top + 2), title, "black")
        for column, picture in enumerate(pictures):
            small = Image.fromarray(picture).resize((WIDTH, HEIGHT))
            sheet.paste(small, (column * WIDTH, top + TEXT))
    with atomic_output(out) as temporary:
        sheet.quantize(colors).save(temporary, "png", optimize=True)

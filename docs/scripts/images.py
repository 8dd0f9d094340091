"""The picture of docs/vision.md: `python docs/scripts/images.py results/D/images/G`.

Depth images, near is bright, of objects that lie alone and of several; in green some of the best
free grasps, in red one that collides.
"""

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from egad._util.files import atomic_output
from egad.bench import SCENE_KINDS
from egad.learning.images import RenderedImage, read

DOCS = Path(__file__).parents[1]
COLUMNS, SCALE = 5, 2
ROWS = (1, 1, 1)  # of each kind of scene
SHOWN = 180  # pixels around the objects, before they are enlarged
FREE, COLLIDING = (20, 190, 60), (220, 50, 40)
JAW = 7  # pixels; half the breadth that is drawn
DEEPEST = 0.08  # metres below the highest point that are drawn black


def main(folder: str) -> None:
    """Write the picture beside this file."""
    images = read(folder)
    table = images.table.drop_duplicates("id").reset_index()
    kinds = [table.loc[table["scene"] == kind, "index"] for kind in SCENE_KINDS]
    chosen = [
        images[number]
        for kind, rows in zip(kinds, ROWS, strict=True)
        for number in kind[: rows * COLUMNS]
    ]
    side = SHOWN * SCALE
    sheet = Image.new("RGB", (COLUMNS * side, sum(ROWS) * side))
    for place, picture in enumerate(chosen):
        row, column = divmod(place, COLUMNS)
        sheet.paste(drawn(picture), (column * side, row * side))
    with atomic_output(DOCS / "images.png") as out:
        sheet.quantize(128).save(out, "png", optimize=True)


def drawn(picture: RenderedImage) -> Image.Image:
    """An image around its object, with grasps."""
    corner = _corner(picture.mask > 0)
    window = tuple(slice(low, low + SHOWN) for low in corner)
    image = Image.fromarray(_shades(picture)[window]).resize((SHOWN * SCALE,) * 2, Image.NEAREST)
    pen = ImageDraw.Draw(image)
    grasps = picture.grasps
    order = np.argsort(-grasps.quality, kind="stable")
    for number in [
        *order[~grasps.collision_free[order]][:1],
        *_apart(picture, order[grasps.collision_free[order]]),
    ]:
        ends = (grasps.ends()[number] - corner[::-1] + 0.5) * SCALE
        color = FREE if grasps.collision_free[number] else COLLIDING
        pen.line([tuple(end) for end in ends.tolist()], fill=color, width=3)
        angle = grasps.angle[number]
        across = JAW * SCALE * np.array([np.sin(angle), np.cos(angle)])
        for end in ends:
            jaw = [tuple((end + sign * across).tolist()) for sign in (-1, 1)]
            pen.line(jaw, fill=color, width=3)
    pen.text((6, 4), f"{picture.label}, {picture.scene}", "white")
    return image


def _apart(picture: RenderedImage, numbers: NDArray[np.int64], most: int = 3) -> list[int]:
    """The best grasps whose angles differ by 30 degrees or more."""
    kept: list[int] = []
    for number in numbers.tolist():
        turns = np.abs(np.cos(picture.grasps.angle[kept] - picture.grasps.angle[number]))
        if (turns < np.cos(np.radians(30))).all() and len(kept) < most:
            kept.append(number)
    return kept


def _corner(mask: NDArray[np.bool_]) -> NDArray[np.int64]:
    rows, columns = np.nonzero(mask)
    middle = np.array([rows.min() + rows.max(), columns.min() + columns.max()]) // 2
    return np.clip(middle - SHOWN // 2, 0, np.array(mask.shape) - SHOWN)


def _shades(picture: RenderedImage) -> NDArray[np.uint8]:
    depth = np.nan_to_num(picture.depth, nan=np.inf)
    bright = np.clip(1 - (depth - depth[picture.mask > 0].min()) / DEEPEST, 0, 1)
    grey = np.where(picture.mask > 0, 70 + 185 * bright, 45 + 20 * bright).astype(np.uint8)
    return np.stack([grey] * 3, axis=-1)


if __name__ == "__main__":
    main(sys.argv[1])

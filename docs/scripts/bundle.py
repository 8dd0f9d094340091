"""Numbers and picture of docs/bundle.md: `python docs/scripts/bundle.py results/D/bundle/G ...`.

It draws the convex parts of some objects of the first bundle in colors: those with the most parts
and the largest errors, and a median one. It prints a line of numbers for every bundle.
"""

import colorsys
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import trimesh
from PIL import Image, ImageDraw

from egad._util.files import atomic_output
from egad.geometry import TriangleScene
from egad.io import read_mesh
from egad.random import generator
from egad.report.pictures import CAMERA, FILL, render
from egad.tables import parquet
from egad.tables.evaluation import BUNDLE

DOCS = Path(__file__).parents[1]
SIZE = 300
APART = 0.12  # of the size: how far parts are drawn apart, so that the inner ones are seen


def main(bundles: list[Path]) -> None:
    """Print the numbers and write the picture beside this file."""
    for bundle in bundles:
        print(numbers(bundle))
    picture = drawn(bundles[0])
    with atomic_output(DOCS / "bundle.png") as path:
        picture.save(path, "png", optimize=True)


def numbers(bundle: Path) -> str:
    """Parts, errors and deviations of a bundle, and the objects that are worst in each."""
    table = parquet.read(bundle / "bundle.parquet", BUNDLE).set_index("label")
    lines = [f"{bundle}: {len(table)} objects, {(~table['within']).sum()} beyond the bound"]
    for column, factor in (("parts", 1), ("volume_error", 100), ("deviation", 1000), ("poses", 1)):
        values = factor * table[column]
        lines.append(
            f"{column}: median {values.median():.2f}, 90 % {values.quantile(0.9):.2f},"
            f" largest {values.max():.2f} ({values.idxmax()})"
        )
    return "\n".join([*lines, f"parts in all: {table['parts'].sum()}"])


def drawn(bundle: Path) -> Image.Image:
    """Objects above, their parts below, a column each."""
    table = parquet.read(bundle / "bundle.parquet", BUNDLE).set_index("label")
    shown = chosen(table)
    sheet = Image.new("RGB", (SIZE * len(shown), 2 * SIZE + 20), "white")
    pen = ImageDraw.Draw(sheet)
    for place, name in enumerate(shown):
        row = table.loc[name]
        text = f"{name}: {row['parts']} parts, {row['volume_error']:.1%}"
        pen.text((SIZE * place + 8, 4), text, fill="#1c2430")
        files = sorted((bundle / name / "parts").glob("*.obj"))
        parts = [read_mesh(file, "m") for file in files]
        for line, picture in enumerate((whole(bundle / name / "visual.obj"), colored(parts))):
            sheet.paste(picture, (SIZE * place, 20 + SIZE * line), picture)
    return sheet


def chosen(table: pd.DataFrame) -> list[str]:
    """The objects with most parts, largest volume error, largest deviation, and median of parts."""
    middle = table["parts"].sort_values().index[len(table) // 2]
    worst = [table[name].idxmax() for name in ("parts", "volume_error", "deviation")]
    return list(dict.fromkeys([*worst, middle]))


def whole(file: Path) -> Image.Image:
    """An object in grey."""
    return Image.fromarray(render(read_mesh(file, "m"), SIZE))


def colored(parts: list[trimesh.Trimesh]) -> Image.Image:
    """Parts, a little apart, in colors that are far from those of their neighbors."""
    middle = np.mean([part.centroid for part in parts], axis=0)
    moved = [part.copy().apply_translation(APART * (part.centroid - middle)) for part in parts]
    shades = np.asarray(render(trimesh.util.concatenate(moved), SIZE), dtype=float)
    hues = generator(0, "part colors").permutation(len(parts)) / len(parts)
    colors = np.array([colorsys.hsv_to_rgb(hue, 0.55, 1.0) for hue in hues])
    index = seen(moved)
    shades[..., :3] *= np.where(index[..., None] >= 0, colors[index], 1.0)
    return Image.fromarray(shades.round().astype(np.uint8))


def seen(parts: list[trimesh.Trimesh]) -> np.ndarray:
    """The part that each pixel of their picture shows, (size, size); -1 for the background."""
    together = trimesh.util.concatenate(parts)
    points = together.vertices @ CAMERA.T
    low, high = points.min(axis=0), points.max(axis=0)
    points = (points - (low + high) / 2) * (2 * FILL / (high - low)[:2].max())
    scene = TriangleScene(points, together.faces)
    centers = (np.arange(SIZE) + 0.5) / SIZE * 2 - 1
    x, y = np.meshgrid(centers, -centers)
    origins = np.stack([x.ravel(), y.ravel(), np.full(x.size, points[:, 2].max() + 1)], axis=1)
    towards = np.tile(np.array([0, 0, -1], dtype=np.float32), (x.size, 1))
    faces = scene.intersections(origins, towards).faces
    owner = np.repeat(np.arange(len(parts)), [len(part.faces) for part in parts])
    return np.where(faces >= 0, owner[faces], -1).reshape(SIZE, SIZE)


if __name__ == "__main__":
    main([Path(name) for name in sys.argv[1:]])

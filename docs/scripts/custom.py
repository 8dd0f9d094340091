"""Pictures of docs/custom.md: `python docs/scripts/custom.py` runs every example.

Runs are kept in build/examples/NAME, and are not repeated.
"""

import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
from PIL import Image

from egad._util.files import atomic_output
from egad.io import read_mesh
from egad.report.pictures import png_bytes, render
from egad.tables import parquet
from egad.tables.objects import OBJECTS

DOCS = Path(__file__).parents[1]
ROOT = DOCS.parent
EXAMPLES = ROOT / "config" / "examples"
SHOWN, SIDE = 9, 96


def main() -> None:
    """Run the examples and write a picture of each beside this file."""
    for config in sorted(EXAMPLES.glob("*.yaml")):
        dataset = made(config)
        objects = parquet.read(dataset / "objects.parquet", OBJECTS)
        labels = spread(objects, SHOWN)
        picture = strip([dataset / "meshes" / f"{label}.obj" for label in labels])
        with atomic_output(DOCS / f"custom-{config.stem}.png") as temporary:
            temporary.write_bytes(picture)
        print(f"{config.stem}: {len(objects)} objects")


def made(config: Path) -> Path:
    """The dataset of an example, run in a folder of its own."""
    folder = ROOT / "build" / "examples" / config.stem
    for name in ("config", "examples"):
        shutil.copytree(ROOT / name, folder / name, dirs_exist_ok=True)
    command = ["snakemake", "--quiet", "all", "--cores", "1", "--directory", str(folder)]
    command += ["--snakefile", str(ROOT / "Snakefile"), "--configfile", str(config)]
    command += ["--", "results/egad/objects.parquet"]
    subprocess.run([sys.executable, "-m", *command], check=True)  # noqa: S603
    return folder / "results" / "egad"


def spread(objects: pd.DataFrame, count: int) -> list[str]:
    """Labels of objects at even distances along complexity, low to high."""
    left = objects.set_index("label")["complexity"].sort_values(kind="stable")
    chosen: list[str] = []
    for value in np.linspace(left.min(), left.max(), min(count, len(left))):
        chosen.append(str((left - value).abs().idxmin()))
        left = left.drop(chosen[-1])
    return chosen


def strip(files: list[Path]) -> bytes:
    """A PNG of meshes side by side."""
    picture = np.hstack([render(read_mesh(path, "m"), SIDE) for path in files])
    alpha = Image.fromarray(picture[..., 3])
    ground = Image.new("RGB", alpha.size, "white")
    ground.paste(Image.fromarray(picture[..., :3]), mask=alpha)
    opaque = np.dstack([np.asarray(ground), np.full(picture.shape[:2], 255, dtype=np.uint8)])
    return png_bytes(opaque)


if __name__ == "__main__":
    main()

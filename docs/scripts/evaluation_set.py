"""Pictures of docs/evaluation-set.md: `python docs/scripts/evaluation_set.py results/D/print/G`.

Draws the first plate of a folder of print files, as it stands on the bed, and an engraved label.
"""

import sys
from pathlib import Path

import numpy as np
import trimesh

from egad._util.arrays import RgbImage
from egad._util.files import atomic_output
from egad.evalset import Patch, cut_text
from egad.report.pictures import CAMERA, png_bytes, render

DOCS = Path(__file__).parents[1]
THICK = 0.005  # metres


def main(prints: Path) -> None:
    """Draw plate 1 with its bed, and the label."""
    plate = trimesh.load_scene(prints / "plate-1.3mf").to_mesh()
    low, high = plate.bounds
    bed = trimesh.creation.box(bounds=[[low[0] - 5, low[1] - 5, -2], [high[0] + 5, high[1] + 5, 0]])
    write("evaluation-set-plate.png", render(trimesh.util.concatenate([plate, bed]), 640))
    write("evaluation-set-label.png", render(labelled("E2"), 320))


def labelled(text: str) -> trimesh.Trimesh:
    """A disc of 22 mm with a label, with flat shading."""
    disc = trimesh.creation.cylinder(0.011, THICK, sections=96)
    right, out = CAMERA[0].astype(np.float64), np.array([0.0, 0.0, 1.0])
    frame = np.column_stack([right, np.cross(out, right), out])
    patch = Patch(THICK / 2 * out, frame, 0.0, 0)
    cut = cut_text(disc, text, patch) or disc
    corners = cut.vertices[cut.faces].reshape(-1, 3)
    return trimesh.Trimesh(corners, np.arange(len(corners)).reshape(-1, 3), process=False)


def write(name: str, picture: RgbImage) -> None:
    """Write a picture beside this file."""
    with atomic_output(DOCS / name) as temporary:
        temporary.write_bytes(png_bytes(picture))


if __name__ == "__main__":
    main(Path(sys.argv[1]))

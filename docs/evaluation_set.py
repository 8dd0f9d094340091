"""Pictures of docs/evaluation-set.md: `python docs/evaluation_set.py results/egad/print/egad_75mm`.

Draws the first plate of a folder of print files, as it stands on the bed.
"""

import sys
from pathlib import Path

import trimesh

from egad.files import replacing
from egad.report.render import png_bytes, render

OUT = Path("docs/evaluation-set-plate.png")


def main(prints: Path) -> None:
    """Draw plate 1 with its bed."""
    plate = trimesh.load_scene(prints / "plate-1.3mf").to_mesh()
    low, high = plate.bounds
    bed = trimesh.creation.box(bounds=[[low[0] - 5, low[1] - 5, -2], [high[0] + 5, high[1] + 5, 0]])
    with replacing(OUT) as temporary:
        temporary.write_bytes(png_bytes(render(trimesh.util.concatenate([plate, bed]), 640)))


if __name__ == "__main__":
    main(Path(sys.argv[1]))

"""collage: one picture of the objects of a dataset, arranged in the space."""

from pathlib import Path

from egad._util.files import atomic_output
from egad._util.progress import progress
from egad.exchange import read_mesh
from egad.pipeline.config import CustomMeasures, Space
from egad.report.axes import axis_pair
from egad.report.pictures import png_bytes, render
from egad.report.space_map import collage, most_diverse
from egad.tables import parquet
from egad.tables.objects import OBJECTS

SIZE = 96


def run(dataset: Path, out: Path, space: Space, axes: CustomMeasures) -> None:
    """Draw the most diverse object of every cell.

    Args:
        dataset: Folder of a dataset, with `objects.parquet` and `meshes/`.
        out: PNG file.
        space: The cells.
        axes: What spans them.
    """
    shown = most_diverse(parquet.read(dataset / "objects.parquet", OBJECTS))
    pictures = {
        label: png_bytes(render(read_mesh(dataset / "meshes" / f"{label}.obj", "m"), SIZE))
        for label in progress(shown["label"], "drawing", len(shown))
    }
    with atomic_output(out) as temporary:
        temporary.write_bytes(collage(shown, pictures, space, axes=axis_pair(axes)))

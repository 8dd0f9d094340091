"""One picture of the objects of a dataset, arranged in the space."""

from functools import partial
from pathlib import Path
from typing import Annotated

from egad._util.progress import progress
from egad._util.workers import workers
from egad.cli.common import CORES, Config, Dataset, Jobs, out_option, settings_in

SIZE = 96


def collage(
    dataset: Dataset,
    out: Annotated[Path, out_option("picture to write: .png")],
    config: Config = None,
    jobs: Jobs = CORES,
) -> None:
    """Draw the objects of a dataset, arranged in the space, as one PNG picture."""
    from egad.io import check_ending

    check_ending(out, (".png",))
    from egad._util.files import atomic_output
    from egad.report.axes import axis_pair
    from egad.report.space_map import collage as arranged
    from egad.report.space_map import most_diverse
    from egad.tables import parquet
    from egad.tables.objects import OBJECTS

    settings = settings_in(config)
    shown = most_diverse(parquet.read(dataset / "objects.parquet", OBJECTS))
    labels = shown["label"].tolist()
    with workers(jobs) as mapper:
        drawn = mapper(partial(_picture, meshes=dataset / "meshes"), labels)
        pictures = dict(zip(labels, progress(drawn, "drawing", len(labels)), strict=True))
    axes = axis_pair(settings.measures)
    with atomic_output(out) as temporary:
        temporary.write_bytes(arranged(shown, pictures, settings.space, axes=axes))


def _picture(label: str, meshes: Path) -> bytes:
    from egad.io import read_mesh
    from egad.report.pictures import png_bytes, render

    return png_bytes(render(read_mesh(meshes / f"{label}.obj", "m"), SIZE))

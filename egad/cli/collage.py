"""Pictures of a whole dataset: its objects arranged in the space, or their number in each cell."""

from functools import partial
from pathlib import Path
from typing import Annotated

from egad._util.progress import progress
from egad._util.workers import workers
from egad.cli.common import CORES, ArchiveFile, Config, Dataset, Jobs, out_option, settings_in

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


def heatmap(
    archive: ArchiveFile,
    out: Annotated[Path, out_option("drawing to write: .svg")],
    config: Config = None,
) -> None:
    """Draw the number of elites per cell of an archive, as SVG."""
    from egad._util.files import write_text
    from egad.config.archive_settings import check_provenance
    from egad.config.stages import MeasureMeshes, select
    from egad.data import archive_path
    from egad.io import check_ending
    from egad.measures import MeasureParameters, attainable_graspability
    from egad.report.axes import axis_pair
    from egad.report.comparison import dataset_maps
    from egad.tables import parquet
    from egad.tables.evolution import ARCHIVE

    check_ending(out, (".svg",))
    settings = settings_in(config)
    check_provenance(archive_path(archive), select(settings, MeasureMeshes), ("space",))
    objects = parquet.read(archive_path(archive), ARCHIVE)
    limit = attainable_graspability(select(settings, MeasureParameters))
    axes = axis_pair(settings.measures)
    maps = dataset_maps({archive.stem: objects}, settings.space, axes, limit.rows)
    write_text(out, maps)

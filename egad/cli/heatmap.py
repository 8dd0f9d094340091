"""The number of elites in each cell."""

from pathlib import Path
from typing import Annotated

from egad.cli import common


def heatmap(
    archive: common.ArchiveFile,
    out: Annotated[Path, common.out_option("drawing to write: .svg")],
    config: common.Config = None,
) -> None:
    """Draw the number of elites per cell of an archive, as SVG."""
    from egad._util.files import write_text
    from egad.data import archive_path
    from egad.io import check_ending
    from egad.measures import MeasureMeshes, MeasureParameters, attainable_graspability
    from egad.report.axes import axis_pair
    from egad.report.comparison import dataset_maps
    from egad.tables import parquet
    from egad.tables.evolution import ARCHIVE
    from egad_workflow.archive_settings import check_provenance
    from egad_workflow.settings import select

    check_ending(out, (".svg",))
    settings = common.settings_in(config)
    check_provenance(archive_path(archive), select(settings, MeasureMeshes), ("space",))
    objects = parquet.read(archive_path(archive), ARCHIVE)
    limit = attainable_graspability(select(settings, MeasureParameters))
    axes = axis_pair(settings.measures)
    maps = dataset_maps({archive.stem: objects}, settings.space, axes, limit.rows)
    write_text(out, maps)

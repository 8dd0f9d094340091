"""image-card: a readable description of a set of rendered images."""

import logging
from pathlib import Path

import pandas as pd

from egad._util.files import write_text
from egad.learning import remove_leftovers
from egad.learning.images import COLUMNS, RenderParameters, card, files, summary
from egad.report.training import openings_chart
from egad.tables import parquet
from egad.tables.objects import REJECTED
from egad_workflow.job import run_job
from egad_workflow.shards import join

log = logging.getLogger(__name__)


def run(
    settings: RenderParameters,
    dataset: str,
    gripper: str,
    images: Path,
    shards: int,
    rejects: list[Path],
    out: Path,
    figure: Path,
    rejected: Path,
) -> None:
    """Write the card of a set of images, and remove leftovers of an earlier, larger set."""
    remove_leftovers(images, ["images"], shards)
    batches = [rows for path in files(images) for rows in parquet.batches(path, COLUMNS)]
    rows = pd.concat(batches) if batches else pd.DataFrame(columns=COLUMNS)
    left_out = join(rejects, REJECTED, ["id", "stage"])
    found = summary(rows, settings.render.quality)
    write_text(out, card(settings, dataset, gripper, found, left_out, figure.name))
    write_text(figure, openings_chart(found.openings, settings.gripper.opening))
    parquet.write(left_out, REJECTED, rejected)
    log.info("%d images, %d objects without any", len(rows), len(left_out))


if __name__ == "__main__":
    run_job(run)

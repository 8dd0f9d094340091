"""collect: combine the objects of all shards into a dataset with cells, labels, diversities."""

import logging
from collections import Counter
from pathlib import Path

import pandas as pd

from egad.errors import UserError, most_common
from egad.geometry import units_doubt
from egad.geometry.repair import warn_of_shapes
from egad.io import write_meshes
from egad.measures import CellsAndDiversities, arrange
from egad.tables import parquet
from egad.tables.objects import OBJECTS, REJECTED, SOLIDS
from egad_workflow.job import run_job
from egad_workflow.shards import join

log = logging.getLogger(__name__)


def run(
    settings: CellsAndDiversities,
    source: str,
    solids: list[Path],
    rejects: list[Path],
    objects: Path,
    rejected: Path,
    meshes: Path,
    jobs: int = 1,
) -> None:
    """Combine the shards of a dataset; only objects from an archive are named after their cells."""
    name = objects.parent.name
    found, left_out = join(solids, SOLIDS, ["id"]), join(rejects, REJECTED, ["id", "stage"])
    if found.empty:
        reasons = most_common(Counter(left_out["reason"]))
        raise UserError(f"{name}: none of {len(left_out)} objects could be used: {reasons}")
    frame = arrange(found, settings, source in ("evolved", "archive"), jobs)
    write_meshes(frame, meshes, jobs)
    if source == "meshes":
        _warn(name, frame, left_out)
    parquet.write(left_out, REJECTED, rejected)
    parquet.write(frame, OBJECTS, objects)
    log.info("%d objects", len(frame))


def _warn(name: str, frame: pd.DataFrame, left_out: pd.DataFrame) -> None:
    """Warn about a user's meshes that could not be used, and about doubts on the others."""
    longest = frame[["extents_x", "extents_y", "extents_z"]].max(axis=1)
    if doubt := units_doubt(dict(zip(frame["id"], longest, strict=True)), None):
        log.warning("%s: %s", name, doubt)
    if len(left_out):
        first = left_out.iloc[0]
        log.warning(
            "%s: %d of %d meshes cannot be used; %s: %s",
            *(name, len(left_out), len(frame) + len(left_out), first["id"], first["reason"]),
        )
    warn_of_shapes(frame, f"{name}: ")


if __name__ == "__main__":
    run_job(run)

"""postprocess: repaired meshes, mass properties and measures of the objects of a shard."""

import logging
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
import trimesh

from egad._util.progress import progress
from egad.errors import RejectedError
from egad.evolution import PostprocessSolids, packed_surface
from egad.geometry import joined_primitives
from egad.io import EVERY_FILE, objects_in, read_mesh
from egad.measures import solid_row
from egad.random import generator
from egad.tables import parquet
from egad.tables.evolution import ARCHIVE
from egad.tables.objects import REJECTED, SOLIDS, rejection
from egad_workflow.archive_settings import MEASURING, archive_notes, check_provenance, differences
from egad_workflow.datasets import DatasetSection
from egad_workflow.job import run_job
from egad_workflow.shards import in_shard

log = logging.getLogger(__name__)
PAPER_ESTIMATES = (
    "The graspability values in %s are rough: percentiles of a few grasps that are kept apart "
    "from each other, biased by selection. The objects are measured again."
)
Sources = dict[str, Callable[[], trimesh.Trimesh]]


def run(
    settings: PostprocessSolids,
    dataset: DatasetSection,
    shard: tuple[int, int],
    solids: Path,
    rejected: Path,
    archive: Path | None = None,
) -> None:
    """Repair and measure the objects of a shard, from an archive, mesh files or primitives."""
    if dataset.folder is not None:
        pattern = dataset.pattern or EVERY_FILE
        sources, known = from_folder(Path(dataset.folder), dataset.units, *shard, pattern)
    elif dataset.objects is not None:
        sources, known = from_primitives(dataset.objects, settings, *shard)
    else:
        assert archive is not None  # noqa: S101 (the rule gives one)
        sources, known = from_archive(archive, settings, *shard)
    measure_objects(settings, sources, known, solids, rejected, resample=archive is None)


def measure_objects(
    settings: PostprocessSolids,
    sources: Sources,
    known: pd.Series,
    out: Path,
    rejected: Path,
    *,
    resample: bool = True,
) -> None:
    """Repair and measure objects from their sources; `known` is graspability, resampled without."""
    rows, left_out = [], []
    for object_id, load in progress(sources.items(), "repairing and measuring", len(sources)):
        try:
            row = solid_row(load(), object_id, settings, resample=resample)
        except RejectedError as reason:
            left_out.append(rejection(object_id, "postprocess", reason))
        else:
            rows.append(row | {"archive_graspability": known.get(object_id, np.nan)})
    log.info("%d objects, %d rejected", len(rows), len(left_out))
    parquet.write(pd.DataFrame(rows), SOLIDS, out)
    parquet.write(pd.DataFrame(left_out), REJECTED, rejected)


def from_archive(
    path: Path, settings: PostprocessSolids, shard: int, shards: int
) -> tuple[Sources, pd.Series]:
    """The evolved objects of a shard, and the graspability by which each was selected."""
    check_provenance(path, settings, ("shape",))
    archive = parquet.read(path, ARCHIVE).set_index("id")
    if archive_notes(path).get("evolution.estimator") == "paper":
        log.info(PAPER_ESTIMATES, path)
    sources: Sources = {
        str(object_id): partial(packed_surface, packed, settings.shape)
        for object_id, packed in archive["voxels"].items()
        if in_shard(str(object_id), shard, shards)
    }
    if other := differences(path, settings, MEASURING):
        log.info(
            "\n".join(
                ["Not compared with the graspability in the archive, as settings differ:", *other]
            )
        )
        return sources, pd.Series(dtype=float)
    return sources, archive["graspability"]


def from_folder(
    folder: Path, units: str | None, shard: int, shards: int, pattern: str = EVERY_FILE
) -> tuple[Sources, pd.Series]:
    """The objects of the mesh files of a shard, without a graspability used for selection."""
    sources: Sources = {
        name: partial(read_mesh, path, units)
        for name, path in objects_in(folder, pattern).items()
        if in_shard(name, shard, shards)
    }
    return sources, pd.Series(dtype=float)


def from_primitives(
    count: int, settings: PostprocessSolids, shard: int, shards: int
) -> tuple[Sources, pd.Series]:
    """The random objects of a shard; one depends on its number, the seed and its size alone."""
    names = {f"p{number:05d}": number for number in range(count)}
    sources: Sources = {
        name: partial(_primitives, settings.seed, number, settings.shape.longest_side)
        for name, number in names.items()
        if in_shard(name, shard, shards)
    }
    return sources, pd.Series(dtype=float)


def _primitives(seed: int, number: int, longest_side: float) -> trimesh.Trimesh:
    return joined_primitives(generator(seed, "primitives", number), longest_side)


if __name__ == "__main__":
    run_job(run)

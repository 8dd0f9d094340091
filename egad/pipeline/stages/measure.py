"""measure: complexity and difficulty of meshes, and their cells."""

import logging
from collections.abc import Iterable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import trimesh

from egad._util.progress import progress
from egad._util.workers import workers
from egad.errors import RejectedError
from egad.exchange import read_mesh
from egad.geometry import Body, repair_and_weigh, units_doubt
from egad.measures import cell_of, coarse_advice, is_coarse, measure_repeatably
from egad.pipeline.config import Postprocess
from egad.pipeline.config.stage_settings import MeasureMeshes
from egad.tables.objects import MEASURED

log = logging.getLogger(__name__)
SIZE = "size_as_read"  # longest side before repair, metres; known of rejected meshes, too


def run(
    settings: MeasureMeshes, files: Mapping[str, Path], units: str | None, worker_count: int
) -> pd.DataFrame:
    """Repair and measure meshes.

    Args:
        settings: Settings of this tool.
        files: Mesh files by name.
        units: Unit of their coordinates; None: as the files say.
        worker_count: Processes; the result does not depend on it.

    Returns:
        Columns of `tables.objects.MEASURED`: one row per mesh, in the given order. For an
        unusable mesh the measures are missing, and `reason` says why.
    """
    work = partial(_row, units=units, settings=settings)
    with workers(min(worker_count, len(files))) as mapper:
        rows = list(progress(mapper(work, files.items()), "measuring", len(files)))
    table = pd.DataFrame(rows, columns=MEASURED.names)
    warn_of_units(rows, units)
    warn_of_coarse(table)
    return table


def measure_row(
    mesh: trimesh.Trimesh, settings: MeasureMeshes
) -> tuple[trimesh.Trimesh, dict[str, Any]]:
    """The repaired mesh and its row of `tables.objects.MEASURED`.

    Raises:
        RejectedError: The mesh cannot be repaired, is too small, or cannot be grasped.
    """
    (solid, repaired, wall), _ = repaired_body(
        mesh, settings.postprocess, settings.material.density
    )
    place = measure_repeatably(solid, settings, settings.postprocess.max_candidates)
    column, row = cell_of(place.complexity, place.difficulty, settings.space)
    return solid, {
        **place._asdict(),
        "complexity_cell": column,
        "difficulty_cell": row,
        "longest_side": float(solid.extents.max()),
        "repaired": repaired,
        "shell_thickness": wall,
    }


def repaired_body(mesh: trimesh.Trimesh, wanted: Postprocess, density: float) -> Body:
    """Repair a mesh and compute its mass properties.

    Raises:
        RejectedError: The mesh cannot be repaired, or is too small.
    """
    return repair_and_weigh(
        mesh,
        density,
        wanted.min_volume,
        wanted.open_surfaces,
        wanted.shell_thickness,
    )


def _row(item: tuple[str, Path], units: str | None, settings: MeasureMeshes) -> dict[str, Any]:
    name, path = item
    found: dict[str, Any] = {"name": name, "reason": ""}
    try:
        mesh = read_mesh(path, units)
        found[SIZE] = float(mesh.extents.max())
        _, row = measure_row(mesh, settings)
    except RejectedError as reason:
        return {**found, "reason": str(reason)}
    return {**found, **row}


def warn_of_coarse(table: pd.DataFrame) -> None:
    """Warn of meshes whose complexity says more of their triangles than of their shape."""
    coarse = table[is_coarse(table["complexity"], table["fine_complexity"])]
    if len(coarse):
        log.warning(
            "%d of %d meshes are too coarse, such as %s: %s",
            *(len(coarse), len(table), coarse.iloc[0, 0]),
            coarse_advice(coarse["fine_complexity"].iloc[0]),
        )


def warn_of_units(rows: Iterable[Mapping[str, Any]], units: str | None) -> None:
    """Warn if the size of meshes suggests that their unit is wrong.

    Args:
        rows: With `name`, and `SIZE` for those that could be read.
        units: Unit that they were read with.
    """
    if doubt := units_doubt({row["name"]: row.get(SIZE, np.nan) for row in rows}, units):
        log.warning("%s", doubt)

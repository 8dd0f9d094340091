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
from egad.geometry import ENLARGED, Body, repair_and_weigh, units_doubt
from egad.geometry.repair import dropped_text, repair
from egad.measures import (
    MAP_RULE,
    cell_of,
    coarse_advice,
    grasped_size,
    is_coarse,
    measure_repeatably,
)
from egad.pipeline.config import Postprocess, Settings
from egad.pipeline.config.stage_settings import MeasureMeshes
from egad.tables.objects import MEASURED

log = logging.getLogger(__name__)
SIZE = "size_as_read"  # longest side before repair, metres; known of rejected meshes, too


def run(
    settings: MeasureMeshes,
    files: Mapping[str, Path],
    units: str | None,
    worker_count: int,
    rule: str = MAP_RULE,
) -> pd.DataFrame:
    """Repair and measure meshes.

    Args:
        settings: Settings of this tool.
        files: Mesh files by name.
        units: Unit of their coordinates; None: as the files say.
        worker_count: Processes; the result does not depend on it.
        rule: At which size grasps are sampled: see `egad.rescale`.

    Returns:
        Columns of `tables.objects.MEASURED`: one row per mesh, in the given order. For an
        unusable mesh the measures are missing, and `reason` says why.
    """
    work = partial(_row, units=units, settings=settings, rule=rule)
    with workers(min(worker_count, len(files))) as mapper:
        rows = list(progress(mapper(work, files.items()), "measuring", len(files)))
    table = pd.DataFrame(rows, columns=MEASURED.names)
    warn_of_units(rows, units)
    warn_of_measures(table)
    return table


def measure_row(
    mesh: trimesh.Trimesh, settings: MeasureMeshes, rule: str = MAP_RULE
) -> tuple[trimesh.Trimesh, dict[str, Any]]:
    """The repaired mesh and its row of `tables.objects.MEASURED`.

    Raises:
        RejectedError: The mesh cannot be repaired, is too small, or cannot be grasped.
    """
    repaired, _ = repaired_body(mesh, settings.postprocess, settings.material.density)
    solid = repaired.mesh
    if settings.measures.difficulty:
        rule = "none"  # a measure of the user gets the mesh as it is
    size = grasped_size(solid, settings, rule)
    place = measure_repeatably(solid, settings, settings.postprocess.max_candidates, size.factor)
    column, row = cell_of(place.complexity, place.difficulty, settings.space)
    return solid, {
        **place._asdict(),
        "complexity_cell": column,
        "difficulty_cell": row,
        "longest_side": float(solid.extents.max()),
        "rule": rule,
        "opening": settings.gripper.opening,
        "factor": size.factor,
        **dict(zip(("grasped_1", "grasped_2", "grasped_3"), size.sides, strict=True)),
        "repaired": repaired.changed,
        "shell_thickness": repaired.shell_thickness,
        "dropped_bodies": repaired.dropped_bodies,
        "dropped_volume": repaired.dropped_volume,
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


def repaired_mesh(mesh: trimesh.Trimesh, name: str) -> trimesh.Trimesh:
    """The repaired mesh; the log says which bodies were left out.

    Raises:
        RejectedError: The mesh cannot be repaired.
    """
    repaired = repair(mesh)
    if repaired.dropped:
        log.warning("%s: %s", name, repaired.dropped)
    return repaired.mesh


def _row(
    item: tuple[str, Path], units: str | None, settings: MeasureMeshes, rule: str
) -> dict[str, Any]:
    name, path = item
    found: dict[str, Any] = {"name": name, "reason": ""}
    try:
        mesh = read_mesh(path, units)
        found[SIZE] = float(mesh.extents.max())
        _, row = measure_row(mesh, settings, rule)
    except RejectedError as reason:
        return {**found, "reason": str(reason)}
    return {**found, **row}


def warn_of_units(rows: Iterable[Mapping[str, Any]], units: str | None) -> None:
    """Warn if the size of meshes suggests that their unit is wrong.

    Args:
        rows: With `name`, and `SIZE` for those that could be read.
        units: Unit that they were read with.
    """
    if doubt := units_doubt({row["name"]: row.get(SIZE, np.nan) for row in rows}, units):
        log.warning("%s", doubt)


def incomparable(settings: Settings, gripper: str, rule: str) -> str:
    """Why cells cannot be compared with the map of a configuration; empty if they can.

    Args:
        settings: The configuration.
        gripper: Name of the gripper that they were measured for.
        rule: The scale rule.
    """
    own = settings.difficulty.gripper
    if settings.measures.difficulty or (rule, gripper) == (MAP_RULE, own):
        return ""
    return (
        f"Cells by the rule {rule} for {gripper} cannot be compared with the map, whose objects "
        f"are measured by {MAP_RULE} for {own}."
    )


def warn_of_measures(table: pd.DataFrame) -> None:
    """Warn of meshes that are measured larger than they are, and as `warn_of_shapes`."""
    larger = table[table["factor"] > ENLARGED]
    if len(larger):
        log.warning(
            "%d of %d meshes are measured larger than they are, %s for one %.3g times: "
            "with --rule none, egad measure takes their real size",
            *(len(larger), len(table), larger["name"].iloc[0], larger["factor"].iloc[0]),
        )
    warn_of_shapes(table)


def warn_of_shapes(table: pd.DataFrame, prefix: str = "") -> None:
    """Warn of meshes that lost bodies, or whose triangles are too large for their complexity.

    Args:
        table: Columns of `tables.objects.SOLIDS` or `MEASURED`; the first has the names.
        prefix: Stands before every warning.
    """
    names = table.iloc[:, 0]
    coarse = is_coarse(table["complexity"], table["fine_complexity"])
    for name, fine in zip(names[coarse][:1], table["fine_complexity"][coarse], strict=False):
        log.warning(
            "%s%d of %d meshes are too coarse, such as %s: %s",
            *(prefix, coarse.sum(), len(table), name, coarse_advice(fine)),
        )
    dropped = table["dropped_bodies"] > 0
    bodies, volumes = table["dropped_bodies"][dropped], table["dropped_volume"][dropped]
    for name, count, volume in zip(names[dropped], bodies, volumes, strict=True):
        log.warning("%s%s: %s", prefix, name, dropped_text(int(count), volume))

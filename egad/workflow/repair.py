"""Repaired meshes, and warnings about them."""

import logging

import pandas as pd
import trimesh

from egad.config import Postprocess
from egad.geometry import Body, repair_and_weigh
from egad.geometry.repair import dropped_text, repair
from egad.measures import coarse_advice, is_coarse

log = logging.getLogger(__name__)


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


def warn_of_shapes(table: pd.DataFrame, prefix: str = "") -> None:
    """Warn of meshes that lost bodies, or whose triangles are too large for their complexity.

    Args:
        table: Columns of `tables.objects.SOLIDS` or `MEASURED`; the first has the names.
        prefix: Prefix of every warning.
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

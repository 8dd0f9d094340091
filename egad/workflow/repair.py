"""Repaired meshes, and warnings about them."""

import logging

import pandas as pd
import trimesh

from egad.config import Postprocess
from egad.geometry import Body, repair_and_weigh
from egad.geometry.repair import dropped_text, repair

log = logging.getLogger(__name__)


def repaired_body(mesh: trimesh.Trimesh, wanted: Postprocess, density: float) -> Body:
    """Repair a mesh, and compute its mass properties; `RejectedError` if it is too small."""
    return repair_and_weigh(
        mesh, density, wanted.min_volume, wanted.open_surfaces, wanted.shell_thickness
    )


def repaired_mesh(mesh: trimesh.Trimesh, name: str) -> trimesh.Trimesh:
    """The repaired mesh, or `RejectedError`; the log says which bodies were left out."""
    repaired = repair(mesh)
    if repaired.dropped:
        log.warning("%s: %s", name, repaired.dropped)
    return repaired.mesh


def warn_of_shapes(table: pd.DataFrame, prefix: str = "") -> None:
    """Warn of meshes that lost bodies; the first column of the table has their names."""
    names = table.iloc[:, 0]
    dropped = table["dropped_bodies"] > 0
    bodies, volumes = table["dropped_bodies"][dropped], table["dropped_volume"][dropped]
    for name, count, volume in zip(names[dropped], bodies, volumes, strict=True):
        log.warning("%s%s: %s", prefix, name, dropped_text(int(count), volume))

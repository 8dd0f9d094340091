"""dexnet-objects: the objects of a shard for a Dex-Net database."""

import logging
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import trimesh

from egad._util.arrays import Floats
from egad._util.progress import progress
from egad.config.stages import DexNetObjects
from egad.errors import RejectedError
from egad.exchange import MEASURES, DexnetObject, add_object, check_key, writing
from egad.geometry import StablePose, distance_field, mass_properties, resting_poses
from egad.io import read_mesh
from egad.tables import parquet
from egad.tables.objects import OBJECTS
from egad.workflow.shards import rows_in_shard

log = logging.getLogger(__name__)


def write_objects(
    settings: DexNetObjects, objects: Path, meshes: Path, shard: tuple[int, int], out: Path
) -> None:
    """Write the objects of a shard for a Dex-Net database: distance fields, stable poses.

    The HDF5 file has a group for each in its group `objects`. If the stable poses of an object
    cannot be computed, it is written without them and logged.
    """
    rows = parquet.records(rows_in_shard(parquet.read(objects, OBJECTS), *shard))
    with writing(out) as file:
        group = file.create_group("objects")
        for row in progress(rows, "computing distance fields", len(rows)):
            key = check_key(row["label"])
            try:
                solid = _solid(settings, row, meshes / f"{key}.obj")
            except RejectedError as reason:
                log.warning("%s is omitted: %s", key, reason)
            else:
                add_object(group, key, solid)


def _solid(settings: DexNetObjects, row: Mapping[str, Any], path: Path) -> DexnetObject:
    mesh = read_mesh(path, "m")
    mass = mass_properties(mesh, settings.material.density)
    wanted = settings.dexnet
    return DexnetObject(
        mesh=mesh,
        mass=mass.mass,
        field=distance_field(mesh, wanted.field_size, wanted.field_padding),
        poses=_poses(mesh, mass.com, wanted.pose_probability, row["label"]),
        name=row["id"],
        measures={name: float(row[name]) for name in MEASURES},
    )


def _poses(mesh: trimesh.Trimesh, com: Floats, least: float, label: str) -> list[StablePose]:
    try:
        return [pose for pose in resting_poses(mesh, com) if pose.probability >= least]
    except RejectedError as reason:
        log.warning("%s is written without stable poses: %s", label, reason)
        return []

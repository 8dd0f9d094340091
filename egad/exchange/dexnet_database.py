"""Dex-Net databases: one HDF5 file with the objects of a dataset and the grasps of a gripper.

The groups and attributes are those that Dex-Net's database classes read. A grasp is a group with
attributes, so there are millions of groups: they are made by the low-level calls of h5py.
"""

import logging
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import trimesh
from h5py import h5a, h5g, h5p, h5s, h5t
from numpy.typing import NDArray

from egad._util.arrays import Floats
from egad._util.progress import progress
from egad.errors import RejectedError
from egad.exchange.distance_field import DistanceField, distance_field
from egad.exchange.hdf5 import add_array, add_group, check_key, writing
from egad.exchange.parameters import DexNetObjects
from egad.geometry import StablePose, mass_properties, resting_poses
from egad.io import read_mesh

log = logging.getLogger(__name__)
UNTIMED = "01-01-1980-00h-00m-00s"  # same input, same bytes
MEASURES = ("complexity", "graspability", "complexity_cell", "difficulty_cell", "diversity")
GRASP_TYPE, FRAME = "ParallelJawPtGrasp3D", "object"
POSE_PROBABILITY = 0.01  # stable poses with a lower probability are omitted
_TEXT = h5py.string_dtype()  # Dex-Net compares strings, and would get bytes from a fixed length


@dataclass(frozen=True)
class DexnetObject:
    """What a database holds about an object, by id: kg, and m in the frame of the grasps."""

    mesh: trimesh.Trimesh
    mass: float
    field: DistanceField
    poses: list[StablePose]
    name: str
    measures: Mapping[str, float]


def add_dataset(
    file: h5py.File,
    dataset: str,
    metrics: Mapping[str, Mapping[str, object]],
    metadata: Mapping[str, str],
) -> h5py.Group:
    """Start a database; the group for the objects of its only dataset; `metrics` are explained."""
    file.attrs["time_created"] = UNTIMED
    group = add_group(file, f"datasets/{dataset}")
    for name, parameters in metrics.items():
        _add_parameters(add_group(group, f"metrics/{name}"), parameters)
    for name, meaning in metadata.items():
        _add_parameters(
            add_group(group, f"metadata/{name}"), {"type": "float", "description": meaning}
        )
    return group.create_group("objects")


def _add_parameters(group: h5py.Group, parameters: Mapping[str, object]) -> None:
    for name, value in parameters.items():
        if isinstance(value, Mapping):
            _add_parameters(group.create_group(name), value)
        else:
            group.attrs[name] = value


def add_object(objects: h5py.Group, key: str, solid: DexnetObject) -> None:
    """Add an object, without grasps."""
    group = objects.create_group(key)
    group.attrs["mass"] = float(solid.mass)
    group.attrs["id"] = solid.name
    group.attrs.update(solid.measures)
    mesh = group.create_group("mesh")
    add_array(mesh, "vertices", np.asarray(solid.mesh.vertices, dtype=np.float64))
    add_array(mesh, "triangles", np.asarray(solid.mesh.faces, dtype=np.int32))
    mesh.create_group("metadata").attrs.update(solid.measures)
    field = group.create_group("sdf")
    add_array(field, "data", solid.field.values)
    field.attrs["origin"] = solid.field.origin
    field.attrs["resolution"] = solid.field.resolution
    _add_poses(group.create_group("stable_poses"), solid)


def _add_poses(group: h5py.Group, solid: DexnetObject) -> None:
    group.attrs["num_stable_poses"] = len(solid.poses)
    for number, pose in enumerate(solid.poses):
        one = group.create_group(f"pose_{number}")
        one.attrs["p"] = pose.probability
        one.attrs["r"] = pose.rotation
        one.attrs["x0"] = np.asarray(solid.mesh.vertices[pose.face[0]], dtype=np.float64)


def add_grasps(
    parent: h5py.Group, gripper: str, configurations: Floats, metrics: Mapping[str, Floats]
) -> None:
    """Add the grasps of a gripper, (n, 10) of `dexnet.configurations`, and (n,) of each metric."""
    group = add_group(parent, f"grasps/{gripper}")
    group.attrs["num_grasps"] = len(configurations)
    untimed = h5p.create(h5p.GROUP_CREATE)
    untimed.set_obj_track_times(False)
    columns = [(name.encode(), np.asarray(values, float)) for name, values in metrics.items()]
    text = h5t.py_create(_TEXT, logical=True)
    kind, frame = np.array(GRASP_TYPE, dtype=_TEXT), np.array(FRAME, dtype=_TEXT)
    for number, configuration in enumerate(np.ascontiguousarray(configurations, dtype=np.float64)):
        grasp = h5g.create(group.id, b"grasp_%d" % number, gcpl=untimed)
        _attribute(grasp, b"id", h5t.NATIVE_INT64, np.array(number))
        _attribute(grasp, b"type", text, kind)
        _attribute(grasp, b"configuration", h5t.NATIVE_DOUBLE, configuration)
        _attribute(grasp, b"frame", text, frame)
        values = h5g.create(grasp, b"metrics", gcpl=untimed)
        for name, column in columns:
            _attribute(values, name, h5t.NATIVE_DOUBLE, column[number : number + 1].reshape(()))


def _attribute(
    place: h5g.GroupID, name: bytes, kind: h5t.TypeID, value: NDArray[np.generic]
) -> None:
    space = h5s.create_simple(value.shape) if value.ndim else h5s.create(h5s.SCALAR)
    h5a.create(place, name, kind, space).write(value)


def write_objects(
    settings: DexNetObjects, rows: list[dict[str, Any]], meshes: Path, out: Path
) -> None:
    """Write `OBJECTS` with distance fields and, if they can be computed, stable poses."""
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
        poses=_poses(mesh, mass.com, row["label"]),
        name=row["id"],
        measures={name: float(row[name]) for name in MEASURES},
    )


def _poses(mesh: trimesh.Trimesh, com: Floats, label: str) -> list[StablePose]:
    try:
        return [pose for pose in resting_poses(mesh, com) if pose.probability >= POSE_PROBABILITY]
    except RejectedError as reason:
        log.warning("%s is written without stable poses: %s", label, reason)
        return []

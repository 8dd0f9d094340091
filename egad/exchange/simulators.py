"""Objects of a simulation bundle: URDF, MJCF and stable poses around the same meshes."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from egad.errors import RejectedError, UserError
from egad.evalset import SimulationObject
from egad.exchange.meshes import read_mesh
from egad.exchange.mjcf import mjcf_text
from egad.exchange.object_meshes import PARTS, VISUAL, write_object_meshes
from egad.exchange.poses import read_poses, write_poses
from egad.exchange.urdf import urdf_text
from egad.geometry import MassProperties


def write_simulation_object(
    folder: Path, name: str, made: SimulationObject, friction: float
) -> None:
    """Write `NAME.urdf`, `NAME.xml` (MJCF), `visual.obj`, `parts/` and `poses.json`.

    Args:
        folder: A new folder.
        name: Of the object.
        made: What is written.
        friction: Sliding friction.
    """
    files = write_object_meshes(folder, made)
    for ending, describe in (("urdf", urdf_text), ("xml", mjcf_text)):
        text = describe(name, files, made.physics, friction)
        (folder / f"{name}.{ending}").write_text(text, encoding="utf-8")
    write_poses(folder, made)


def read_simulation_object(bundle: Path, row: Mapping[str, Any]) -> SimulationObject:
    """An object of a simulation bundle.

    Args:
        bundle: The folder of the bundle.
        row: Columns of `tables.evaluation.BUNDLE` of the object.

    Raises:
        UserError: A file of the object is missing or damaged.
    """
    folder = bundle / row["label"]
    paths = sorted((folder / PARTS).glob("*.obj"), key=lambda path: (len(path.name), path.name))
    if len(paths) != row["parts"]:
        raise UserError(
            f"{folder / PARTS}: {len(paths)} convex parts, but {bundle / 'bundle.parquet'} lists "
            f"{row['parts']}; make the bundle again"
        )
    try:
        mesh, *parts = (read_mesh(path, "m") for path in (folder / VISUAL, *paths))
    except RejectedError as reason:
        raise UserError(f"{folder}: {reason}; make the bundle again") from reason
    xx, yy, zz, xy, xz, yz = (
        row[f"inertia_{axes}"] for axes in ("xx", "yy", "zz", "xy", "xz", "yz")
    )
    physics = MassProperties(
        volume=row["volume"],
        area=float(mesh.area),
        com=np.array([row["com_x"], row["com_y"], row["com_z"]]),
        mass=row["mass"],
        inertia=np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]),
    )
    return SimulationObject(
        mesh=mesh,
        parts=tuple(parts),
        physics=physics,
        poses=read_poses(folder, mesh, physics.com),
        volume_error=row["volume_error"],
        deviation=row["deviation"],
        buried=row["buried"],
    )

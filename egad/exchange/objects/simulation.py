"""Objects of a simulation bundle: URDF, MJCF and stable poses around the same meshes."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from egad._util.arrays import Floats
from egad.errors import RejectedError, UserError
from egad.exchange.grasp_tables import by_object
from egad.exchange.object_files import PARTS, VISUAL, write_object_meshes, write_poses
from egad.exchange.objects.mjcf import mjcf_text
from egad.exchange.objects.urdf import urdf_text
from egad.geometry import MassProperties
from egad.io import read_mesh
from egad.sim import SimulationObject, simulation_object, warn_of_row
from egad.tables.columns import INERTIA
from egad.tables.evaluation import CONVEX_PARTS


def write(folder: Path, name: str, made: SimulationObject, friction: float) -> None:
    """Write the folder `NAME` with `NAME.urdf`, `NAME.xml` (MJCF), its meshes and `poses.json`."""
    write_simulation_object(folder / name, name, made, friction)


def write_simulation_object(
    folder: Path, name: str, made: SimulationObject, friction: float
) -> None:
    """Write `NAME.urdf`, `NAME.xml` (MJCF), `visual.obj`, `parts/` and `poses.json`."""
    files = write_object_meshes(folder, made)
    urdf = urdf_text(name, files, made.physics, friction)
    mjcf = mjcf_text(name, files, made, friction)
    for ending, text in (("urdf", urdf), ("xml", mjcf)):
        (folder / f"{name}.{ending}").write_text(text, encoding="utf-8")
    write_poses(folder, made)


def read_simulation_object(bundle: Path, row: Mapping[str, Any]) -> SimulationObject:
    """An object by its row of `BUNDLE`; UserError if a file is missing or damaged."""
    warn_of_row(row)
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
    physics = MassProperties(
        volume=row["volume"],
        area=float(mesh.area),
        com=np.array([row["com_x"], row["com_y"], row["com_z"]]),
        mass=row["mass"],
        inertia=inertia_tensor(row),
    )
    return SimulationObject(
        mesh=mesh,
        parts=tuple(parts),
        physics=physics,
        volume_error=row["volume_error"],
        deviation=row["deviation"],
        buried=row["buried"],
        deviation_bound=row["deviation_bound"],
        within=row["within"],
    )


def read_convex_objects(
    convex_parts: Path, meshes: Path, density: float
) -> Iterator[tuple[str, SimulationObject]]:
    """The objects of a table, `CONVEX_PARTS`, by ascending labels; density in kg/m3."""
    columns = [name for name in CONVEX_PARTS.names if name != "label"]
    for label, rows in by_object(convex_parts, columns):
        yield label, simulation_object(read_mesh(meshes / f"{label}.obj", "m"), density, rows)


def inertia_tensor(row: Mapping[str, Any]) -> Floats:
    """The tensor (3, 3) of a row with these columns."""
    tensor = np.empty((3, 3))
    for name, (first, second) in INERTIA.items():
        tensor[first, second] = tensor[second, first] = row[f"inertia_{name}"]
    return tensor

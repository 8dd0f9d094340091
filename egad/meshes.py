"""Meshes of users: read, scaled to a gripper, decomposed, laid on a table."""

from pathlib import Path

import trimesh

from egad._util.arguments import check_positive
from egad._util.files import as_path
from egad._util.parameters import MAX_SIDE_FRACTION
from egad.geometry import (
    SIDE_FRACTION,
    check_units,
    scaling,
)
from egad.grippers import Gripper, as_gripper
from egad.io import read_mesh as read_any_mesh


def read_mesh(path: str | Path, units: str | None = None) -> trimesh.Trimesh:
    """Read a mesh file as one mesh in metres: obj, stl, ply, off, glb or 3mf.

    Polygons become triangles that lie within them. All objects, groups and nodes become one mesh,
    where the file puts them; vertices at the same place are merged. Colors, materials and normals
    are left out. glTF files have y up: they are turned to have z up. `docs/guides/own-meshes.md`
    lists what is read of each format.

    Args:
        path: The file.
        units: Unit of its coordinates: `m`, `cm`, `mm` or `inch`. It may be left out if the file
            states it (3mf, or a comment such as `unit: mm`), or the format does (glb: metres).

    Raises:
        RejectedError: The file is damaged, is not a mesh, has no faces, or has a feature that is
            not read, such as a free-form surface or a compressed mesh; the message names it. Or it
            states another unit than the one given, or neither gives one.
        UserError: The unit is unknown, or `path` is not a path.

    Warns:
        UnitsWarning: The size of the mesh suggests another unit.
    """
    file = as_path("path", path)
    mesh = read_any_mesh(file, units)
    check_units(mesh, f"the mesh {file.name}", units or "the unit of the file")
    return mesh


def rescale(
    mesh: trimesh.Trimesh,
    gripper: Gripper | str,
    rule: str = "paper",
    *,
    side_fraction: float = SIDE_FRACTION,
) -> tuple[trimesh.Trimesh, float]:
    """Scale an object about the origin of its coordinates to fit a gripper.

    Coordinates in single precision, such as those of the released objects, are rounded to single
    precision again.

    Args:
        mesh: Metres; not changed.
        gripper: The gripper, or its name.
        rule: `paper`: the smallest side of the minimum-volume box becomes at most the fraction of
            the opening, smaller objects stay as they are. `egad-script`: the longest side becomes
            the opening, then as `paper`. `exact`: the smallest side becomes the fraction. `none`:
            the object stays as it is.
        side_fraction: Fraction of the opening that the rule aims at.

    Returns:
        The scaled mesh, and the factor.

    Raises:
        RejectedError: The mesh is flat.
        UserError: There is no such gripper or rule, or the fraction is out of bounds.

    Warns:
        UnitsWarning: The size of the mesh suggests a unit other than the metre.
    """
    check_units(mesh)
    fraction = check_positive("side_fraction", side_fraction, MAX_SIDE_FRACTION)
    scaled, row = scaling.rescale(mesh, rule, as_gripper(gripper).opening, fraction)
    return scaled, row["factor"]

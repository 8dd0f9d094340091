"""Mesh files of users, with a warning if their unit looks wrong."""

from pathlib import Path

import trimesh

from egad._util.files import as_path
from egad.geometry import check_units
from egad.io import mesh as files


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
    mesh = files.read_mesh(file, units)
    check_units(mesh, f"the mesh {file.name}", units or "the unit of the file")
    return mesh

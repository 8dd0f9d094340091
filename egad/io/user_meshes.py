"""Mesh files of users: the result of each, or why there is none, and whether its unit is right."""

import logging
from collections import deque
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import TypeVar

import numpy as np
import pandas as pd
import trimesh

from egad._util.files import as_path, atomic_output
from egad._util.progress import progress
from egad._util.workers import workers
from egad.errors import RejectedError
from egad.geometry import check_units, units_doubt
from egad.io import mesh as files
from egad.io.obj import write_obj

T = TypeVar("T")
log = logging.getLogger(__name__)


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


def use_mesh(
    path: Path, units: str | None, use: Callable[[trimesh.Trimesh], T]
) -> tuple[T | str, float]:
    """What is made from a mesh file, or the reason why nothing is; its longest side, or NaN."""
    longest = np.nan
    try:
        mesh = files.read_mesh(path, units)
        longest = float(mesh.extents.max())
        return use(mesh), longest
    except RejectedError as reason:
        return str(reason), longest


def warn_of_units(sides: Mapping[str, float], units: str | None) -> None:
    """Warn if the size of meshes, longest sides in metres, suggests that their unit is wrong."""
    if doubt := units_doubt(sides, units):
        log.warning("%s", doubt)


def write_meshes(frame: pd.DataFrame, out: Path, jobs: int = 1) -> None:
    """Write the meshes of objects, `label`, `vertices` and `faces`, as `LABEL.obj`, in metres."""
    with workers(jobs) as mapper, atomic_output(out) as folder:
        folder.mkdir()
        columns = zip(frame["label"], frame["vertices"], frame["faces"], strict=True)
        written = mapper(partial(_write, folder), columns)
        deque(progress(written, "writing meshes", len(frame)), maxlen=0)


def _write(folder: Path, row: tuple[str, np.ndarray, np.ndarray]) -> None:
    label, vertices, faces = row
    mesh = trimesh.Trimesh(vertices.reshape(-1, 3), faces.reshape(-1, 3), process=False)
    write_obj(mesh, folder / f"{label}.obj")

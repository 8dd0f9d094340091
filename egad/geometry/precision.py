"""Single precision: coordinates that every mesh format holds exactly.

STL, PLY and GLB files hold single-precision numbers, and so do most programs that read OBJ. A mesh
with such coordinates is bit-identical in all formats and programs, as long as they keep its unit.
STL files that egad writes are in millimetres, so their coordinates are rounded once more.
"""

import numpy as np
import trimesh
from numpy.typing import ArrayLike

from egad._util.arrays import Floats


def to_single(coordinates: ArrayLike) -> Floats:
    """Coordinates rounded to single precision, as doubles; infinite where they are too large."""
    with np.errstate(over="ignore"):
        return np.asarray(coordinates, dtype=np.float32).astype(np.float64)


def is_single(coordinates: ArrayLike) -> bool:
    """Whether rounding to single precision changes nothing."""
    return bool(np.array_equal(to_single(coordinates), np.asarray(coordinates)))


def in_single_precision(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """A copy of a mesh with coordinates rounded to single precision, and the same faces."""
    return trimesh.Trimesh(to_single(mesh.vertices), mesh.faces, process=False)

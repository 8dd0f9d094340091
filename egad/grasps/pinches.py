"""Which part of a surface fits between the fingers of a gripper (ours)."""

import numpy as np
import trimesh
from numpy.typing import NDArray

from egad.grasps.rays import RayCaster

Floats = NDArray[np.float64]

SKIN = 1e-6  # of the size of the mesh: how far below the surface rays start


def pinch_widths(mesh: trimesh.Trimesh) -> tuple[Floats, Floats]:
    """How thick a solid is behind the middle of each triangle, straight along the normal.

    Args:
        mesh: A closed surface, wound outwards.

    Returns:
        Widths, (n,), in the unit of the mesh, and areas of the triangles, (n,).
    """
    inwards = -np.asarray(mesh.face_normals)
    skin = SKIN * float(np.max(mesh.extents))
    starts = np.asarray(mesh.triangles_center) + skin * inwards
    return RayCaster(mesh).first_hits(starts, inwards).distances + skin, np.asarray(mesh.area_faces)


def fitting_part(widths: Floats, areas: Floats, opening: float) -> float:
    """The part of the surface, by area, whose widths are at most the opening."""
    return float(areas[widths <= opening].sum() / areas.sum())

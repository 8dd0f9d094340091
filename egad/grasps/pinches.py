"""Which part of a surface fits between the fingers of a gripper (ours)."""

import numpy as np
import trimesh
from numpy.typing import NDArray

from egad.grasps.rays import RayCaster
from egad.shapes.samples import spread

Floats = NDArray[np.float64]

SPACING = 0.05  # of the longest side of the mesh: between the points, at most
SKIN = 1e-6  # of it: how far below the surface rays start


def pinch_widths(mesh: trimesh.Trimesh) -> tuple[Floats, Floats]:
    """How thick a solid is behind points spread over its surface, straight along the normals.

    Args:
        mesh: A closed surface, wound outwards.

    Returns:
        Widths, (n,), in the unit of the mesh, and the area that each stands for, (n,).
    """
    size = float(np.max(mesh.extents))
    samples = spread(mesh, SPACING * size)
    starts = samples.points - SKIN * size * samples.normals
    hits = RayCaster(mesh).first_hits(starts, -samples.normals)
    shares = np.bincount(samples.faces, minlength=len(mesh.faces))
    return hits.distances + SKIN * size, (mesh.area_faces / np.maximum(shares, 1))[samples.faces]


def fitting_part(widths: Floats, areas: Floats, opening: float) -> float:
    """The part of the surface, by area, whose widths are at most the opening."""
    return float(areas[widths <= opening].sum() / areas.sum())

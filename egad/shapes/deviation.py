"""How far a surface strays from another."""

import numpy as np
import trimesh

from egad.shapes.distances import nearest
from egad.shapes.samples import spread

STEP = 0.02  # of the longest side: distance between the points that are looked at


def largest_deviation(surface: trimesh.Trimesh, mesh: trimesh.Trimesh) -> float:
    """Largest distance from points of a surface to the nearest point of a mesh (ours).

    The points are the corners of the surface and others between them, at most 2 % of the longest
    side of the mesh apart, so a narrow peak between them is missed by at most that much.

    Args:
        surface: Where the points lie.
        mesh: What they should lie on, in the same unit.
    """
    step = STEP * float(np.ptp(mesh.vertices, axis=0).max())
    corners = np.asarray(surface.vertices)[np.unique(surface.faces)]
    points = np.concatenate([corners, spread(surface, step).points])
    return float(nearest(points, mesh)[0].max())

"""How far a surface strays from another."""

import numpy as np
import trimesh
from numpy.typing import NDArray

from egad.shapes.distances import nearest
from egad.shapes.samples import spread

Floats = NDArray[np.float64]

STEP = 0.02  # of the longest side: distance between the points that are looked at
CELL = 0.5  # of that distance
ROUNDING = 1e-9  # relative


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
    return _furthest(np.concatenate([corners, spread(surface, step).points]), mesh, CELL * step)


def _furthest(points: Floats, mesh: trimesh.Trimesh, size: float) -> float:
    """The largest distance of points (n, 3) from a mesh.

    Thin triangles have many points in the same spot. So one point of each cell of a grid is tried,
    and the others only where they can be further away than all of these.
    """
    cells = np.floor((points - points.min(axis=0)) / size).astype(np.int64)
    numbers = np.ravel_multi_index(tuple(cells.T), tuple(cells.max(axis=0) + 1))
    _, first, cell = np.unique(numbers, return_index=True, return_inverse=True)
    distances = nearest(points[first], mesh)[0]
    largest = float(distances.max())
    reach = (distances + np.sqrt(3) * size) * (1 + ROUNDING)
    others = points[(reach >= largest)[cell]]
    return max(largest, float(nearest(others, mesh)[0].max()))

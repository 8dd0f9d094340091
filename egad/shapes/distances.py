"""How far points lie from a surface."""

import igl
import numpy as np
import trimesh
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def nearest(points: Floats, mesh: trimesh.Trimesh) -> tuple[Floats, Floats]:
    """The nearest point of a mesh to each point, exact: libigl's.

    Args:
        points: (n, 3).
        mesh: In the same unit; triangles without area are left out.

    Returns:
        Distances, (n,), and the nearest points of the mesh, (n, 3).
    """
    faces = np.asarray(mesh.faces, dtype=np.int64)[np.asarray(mesh.area_faces) > 0]
    vertices = np.asarray(mesh.vertices, dtype=np.float64)
    around = np.ascontiguousarray(points, dtype=np.float64)
    squared, _, found = igl.point_mesh_squared_distance(around, vertices, faces)
    return np.sqrt(squared).reshape(-1), found.reshape(-1, 3)

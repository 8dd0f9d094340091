"""How far a surface strays from another."""

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.spatial import cKDTree

Floats = NDArray[np.float64]

STEP = 0.02  # of the longest side: distance between the points that are looked at
NEAREST = 8  # triangles whose middles are nearest; the nearest triangle is among them
HALVINGS = 20


def largest_deviation(surface: trimesh.Trimesh, mesh: trimesh.Trimesh) -> float:
    """Largest distance from points of a surface to the nearest point of a mesh (ours).

    The points are the corners of the surface and others between them, at most 2 % of the longest
    side of the mesh apart, so a narrow peak between them is missed by at most that much.

    Args:
        surface: Where the points lie.
        mesh: What they should lie on, in the same unit.
    """
    step = STEP * float(np.ptp(mesh.vertices, axis=0).max())
    points, _ = _fine(surface, step)
    vertices, faces = _fine(mesh, step)
    triangles = vertices[faces]
    near = min(NEAREST, len(triangles))
    _, index = cKDTree(triangles.mean(axis=1)).query(points, k=np.arange(1, near + 1))
    repeated = np.repeat(points, near, axis=0)
    closest = trimesh.triangles.closest_point(triangles[index.ravel()], repeated)
    away = np.linalg.norm(closest - repeated, axis=1).reshape(-1, near)
    return float(np.nanmin(away, axis=1).max())


def _fine(mesh: trimesh.Trimesh, step: float) -> tuple[Floats, NDArray[np.int64]]:
    """Vertices and faces, cut until no edge is longer than a step."""
    vertices, faces = trimesh.remesh.subdivide_to_size(
        mesh.vertices, mesh.faces, max_edge=step, max_iter=HALVINGS
    )
    return np.asarray(vertices, dtype=np.float64), np.asarray(faces, dtype=np.int64)

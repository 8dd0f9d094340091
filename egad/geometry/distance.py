"""Distances to surfaces: of points, and of another surface."""

import numpy as np
import trimesh

from egad._util.arrays import Floats
from egad._util.extras import needed_for
from egad.geometry.surface_samples import spread

STEP = 0.02  # of the longest side: distance between the sampled points
CELL = 0.5  # of that distance
ROUNDING = 1e-9  # relative
WHAT = "the distance to a surface"


def nearest(points: Floats, mesh: trimesh.Trimesh) -> tuple[Floats, Floats]:
    """Distances (n,) of points from a mesh, and its nearest points (n, 3), exactly, by libigl."""
    with needed_for(WHAT):
        import igl  # noqa: PLC0415 (an extra)
    faces = np.asarray(mesh.faces, dtype=np.int64)[np.asarray(mesh.area_faces) > 0]
    vertices = np.asarray(mesh.vertices, dtype=np.float64)
    around = np.ascontiguousarray(points, dtype=np.float64)
    squared, _, found = igl.point_mesh_squared_distance(around, vertices, faces)
    return np.sqrt(squared).reshape(-1), found.reshape(-1, 3)


def largest_deviation(surface: trimesh.Trimesh, mesh: trimesh.Trimesh) -> float:
    """Largest distance of points on a surface, 2 % of its size apart, from a mesh (ours)."""
    step = STEP * float(np.ptp(mesh.vertices, axis=0).max())
    corners = np.asarray(surface.vertices)[np.unique(surface.faces)]
    return _furthest(np.concatenate([corners, spread(surface, step).points]), mesh, CELL * step)


def _furthest(points: Floats, mesh: trimesh.Trimesh, size: float) -> float:
    """The largest distance of points from a mesh: of one per cell, then where it can be more."""
    cells = np.floor((points - points.min(axis=0)) / size).astype(np.int64)
    numbers = np.ravel_multi_index(tuple(cells.T), tuple(cells.max(axis=0) + 1))
    _, first, cell = np.unique(numbers, return_index=True, return_inverse=True)
    distances = nearest(points[first], mesh)[0]
    largest = float(distances.max())
    reach = (distances + np.sqrt(3) * size) * (1 + ROUNDING)
    others = points[(reach >= largest)[cell]]
    return max(largest, float(nearest(others, mesh)[0].max()))

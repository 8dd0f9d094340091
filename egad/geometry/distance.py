"""Distances to surfaces: of points, of another surface, and on a grid (distance field)."""

from typing import NamedTuple

import numpy as np
import trimesh

from egad._util.arrays import Floats, Singles
from egad._util.extras import needed_for
from egad.geometry.surface_samples import spread

STEP = 0.02  # of the longest side: distance between the sampled points
CELL = 0.5  # of that distance
ROUNDING = 1e-9  # relative
WHAT = "the distance to a surface"
STEPS = 10  # binary digits of a distance within a cell: a thousandth


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


class DistanceField(NamedTuple):
    """Signed distances on a cubic grid."""

    values: Singles  # (n, n, n) metres along x, y, z; negative within the solid
    origin: Floats  # (3,) position of the first node, metres
    resolution: float  # distance between two neighboring nodes, metres


def distance_field(mesh: trimesh.Trimesh, size: int, padding: int) -> DistanceField:
    """The distance field of a solid on Dex-Net's SDFGen grid: `size - 2 * padding` cells along it.

    Distances are rounded to a power of two, to compress. Sign: Barill et al., SIGGRAPH 2018.
    """
    with needed_for(WHAT):
        import igl  # noqa: PLC0415 (an extra)
    low, high = np.asarray(mesh.bounds)
    resolution = float((high - low).max()) / (size - 2 * padding)
    origin = (low + high) / 2 - size // 2 * resolution
    nodes = grid_nodes(size, origin, resolution)
    vertices = np.ascontiguousarray(mesh.vertices, dtype=np.float64)
    faces = np.ascontiguousarray(mesh.faces, dtype=np.int64)
    squared, _, _ = igl.point_mesh_squared_distance(nodes, vertices, faces)
    within = igl.fast_winding_number(vertices, faces, nodes) > 0.5
    distances = np.where(within, -1.0, 1.0) * np.sqrt(squared)
    step = 2.0 ** (np.floor(np.log2(resolution)) - STEPS)
    rounded = (step * np.round(distances / step)).astype(np.float32)
    return DistanceField(rounded.reshape(size, size, size), origin, resolution)


def grid_nodes(size: int, origin: Floats, resolution: float) -> Floats:
    """Positions of the nodes, x slowest and z fastest, (size**3, 3), metres."""
    steps = np.moveaxis(np.indices((size, size, size)), 0, -1).reshape(-1, 3)
    return np.asarray(origin + resolution * steps)

"""Signed distances of a solid on a grid, as Dex-Net keeps them."""

from typing import NamedTuple

import numpy as np
import trimesh

from egad._util.arrays import Floats, Singles
from egad._util.extras import needed_for

STEPS = 10  # binary digits of a distance within a cell: a thousandth


class DistanceField(NamedTuple):
    """Signed distances on a cubic grid."""

    values: Singles  # (n, n, n) metres along x, y, z; negative within the solid
    origin: Floats  # (3,) position of the first node, metres
    resolution: float  # distance between two neighboring nodes, metres


def distance_field(mesh: trimesh.Trimesh, size: int, padding: int) -> DistanceField:
    """The distance field of a solid on Dex-Net's SDFGen grid: `size - 2 * padding` cells along it.

    Distances are rounded to a power of two, to compress. Sign: Barill et al., SIGGRAPH 2018.
    """
    with needed_for("the distance to a surface"):
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

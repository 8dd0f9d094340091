"""Distance fields: how far the nodes of a grid are from the surface of a solid."""

from typing import NamedTuple

import igl
import numpy as np
import trimesh
from numpy.typing import NDArray

Floats = NDArray[np.float64]
STEPS = 10  # binary digits of a distance within a cell: a thousandth


class DistanceField(NamedTuple):
    """Signed distances on a cubic grid.

    Attributes:
        values: (n, n, n) metres along x, y, z; negative within the solid.
        origin: (3,) place of the first node, metres.
        resolution: Distance of two neighbouring nodes, metres.
    """

    values: NDArray[np.float32]
    origin: Floats
    resolution: float


def distance_field(mesh: trimesh.Trimesh, size: int, padding: int) -> DistanceField:
    """The distance field of a solid, on the grid that SDFGen lays around it.

    The longest side of the axis-aligned box is `size - 2 * padding` cells long, and node
    `size // 2` lies in the middle of the box. Distances are exact but for rounding to a power of
    two, about a thousandth of a cell: that halves the field when it is compressed.

    Args:
        mesh: A surface around a solid, metres, wound outwards.
        size: Nodes a side.
        padding: Cells between the box and the edge of the grid.

    Source: the grid from SDFGen as Dex-Net calls it (100 nodes, 5 cells); distances from libigl's
    tree of triangles; sign by the winding number, Barill et al., SIGGRAPH 2018.
    """
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
    """Places of the nodes, x slowest and z fastest, (size**3, 3), metres."""
    steps = np.moveaxis(np.indices((size, size, size)), 0, -1).reshape(-1, 3)
    return np.asarray(origin + resolution * steps)

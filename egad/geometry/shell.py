"""Shells: a wall of a given thickness around an open surface."""

from contextlib import suppress

import numpy as np
import trimesh

from egad._util.arrays import Floats, Ints
from egad._util.extras import needed_for
from egad.errors import RejectedError
from egad.geometry.checks import check_surface, cone_volumes
from egad.geometry.distance import nearest
from egad.geometry.manifold import Solid, to_solid
from egad.geometry.self_intersections import untangle

CELLS = 4  # of the grid across a wall
OFFSET = 0.37  # of a cell: so that flat surfaces rarely lie in a plane of nodes
ROUNDING = 2**20 + 1  # steps per thickness, odd: the level lies midway between two of them
TOLERANCES = (0.02, 0.005, 0.001)  # of the thickness: how far simplification may move the surface
MAX_SPREAD = 30_000  # area over thickness squared; 0.12 m2 with a wall of 2 mm: 20 s and 1.8 GB


def shell(mesh: trimesh.Trimesh, thickness: float) -> Solid:
    """All points within half a thickness of a surface, as a solid without voids (ours, on libigl).

    Faces may cross; marching cubes on octree cells of a quarter of the thickness keep walls within
    5 %. `RejectedError` if the wall is thicker than the surface is large, or too thin to compute.
    """
    check_surface(mesh)
    _check_thickness(mesh, thickness)
    solid = to_solid(*_without_voids(*_level_set(mesh, thickness)))
    for tolerance in TOLERANCES:  # as far as the surface can be kept from passing through itself
        with suppress(RejectedError):
            return untangle(solid.simplify(tolerance * thickness))
    return solid


def _check_thickness(mesh: trimesh.Trimesh, thickness: float) -> None:
    size, thinnest = float(mesh.extents.max()), float(np.sqrt(mesh.area / MAX_SPREAD))
    if thickness >= size:
        raise RejectedError(
            f"open surface of {size:.3g} m, smaller than the thickness of its shell, "
            f"{thickness:.3g} m: is the unit of the mesh right?"
        )
    if thickness < thinnest:
        raise RejectedError(
            f"open surface with an area of {mesh.area:.3g} m2: its shell must have a thickness of "
            f"at least {thinnest:.3g} m, not {thickness:.3g} m; is the unit of the mesh right?"
        )


def _level_set(mesh: trimesh.Trimesh, thickness: float) -> tuple[Floats, Ints]:
    """Vertices and faces of the surface at half a thickness, wound outwards."""
    with needed_for("a shell around an open surface"):
        import igl  # noqa: PLC0415 (an extra)
    step, level = thickness / ROUNDING, thickness / 2

    def distance(points: Floats) -> Floats:
        """Rounded: the order of the triangles has no effect, and no node lies on the level."""
        return np.asarray(np.round(nearest(points, mesh)[0] / step) * step)

    def to_level(points: Floats) -> Floats:
        return np.maximum(np.abs(distance(points) - level) - step, 0)

    low, high = mesh.triangles.min(axis=(0, 1)), mesh.triangles.max(axis=(0, 1))
    cell = thickness / CELLS
    depth = int(np.ceil(np.log2((float((high - low).max()) + thickness) / cell + 2)))
    side = cell * 2**depth
    corner = (low + high - side) / 2 + OFFSET * cell
    cells = igl.lipschitz_octree(corner, side, depth, to_level)
    _, corners, nodes = igl.unique_sparse_voxel_corners(corner, side, depth, cells)
    vertices, faces, _ = igl.marching_cubes(distance(nodes), nodes, corners, level)
    return vertices, faces


def _without_voids(vertices: Floats, faces: Ints) -> tuple[Floats, Ints]:
    """The components of a surface that bound something from outside."""
    edges = faces[:, [0, 1, 1, 2]].reshape(-1, 2)
    group = trimesh.graph.connected_component_labels(edges, node_count=len(vertices))
    outer = np.bincount(group[faces[:, 0]], weights=cone_volumes(vertices, faces)) > 0
    return vertices, faces[outer[group[faces[:, 0]]]]

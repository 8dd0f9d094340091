"""Boxes, ellipsoids, cylinders and meshes as voxels of the cube that shapes grow in (ours)."""

import numpy as np
import trimesh
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from numpy.typing import NDArray

from egad.errors import UserError
from egad.settings import Region

Floats = NDArray[np.float64]
Voxels = NDArray[np.bool_]
EDGE = 1 + 1e-9  # a voxel whose middle lies on the edge belongs to the region
OBLIQUE = np.array([0.43951, 0.61760, 0.65223])  # along no face that people draw


def region_voxels(region: Region, resolution: int, mesh: trimesh.Trimesh | None = None) -> Voxels:
    """The voxels whose middles lie in a region.

    Args:
        region: Its kind is not `none`.
        resolution: Voxels along each side of the cube.
        mesh: For a region of that kind: closed, wound outwards, of any size.

    Returns:
        (resolution, resolution, resolution).

    Raises:
        UserError: The region is a mesh, and there is none.
    """
    points = voxel_middles(resolution) - np.array(region.centre)
    if region.kind == "mesh":
        if mesh is None:
            raise UserError(f"the mesh {region.mesh} of a region was not read")
        inside = _within(_fitted(mesh, np.array(region.size)), points)
    else:
        inside = _within_primitive(region, 2 * points / np.array(region.size))
    return inside.reshape((resolution,) * 3)


def voxel_middles(resolution: int) -> Floats:
    """(resolution^3, 3) in C order, in a cube with sides of 1 and its middle at 0."""
    places = np.indices((resolution,) * 3).reshape(3, -1).T
    return np.asarray((places + 0.5) / resolution - 0.5)


def _within_primitive(region: Region, scaled: Floats) -> Voxels:
    """Which points lie in a region, given in halves of its sides from its middle."""
    if region.kind == "box":
        return np.asarray(np.abs(scaled).max(axis=1) <= EDGE)
    if region.kind == "ellipsoid":
        return np.asarray((scaled**2).sum(axis=1) <= EDGE)
    along = "xyz".index(region.axis)
    across = np.delete(scaled, along, axis=1)
    return np.asarray(((across**2).sum(axis=1) <= EDGE) & (np.abs(scaled[:, along]) <= EDGE))


def _fitted(mesh: trimesh.Trimesh, size: Floats) -> trimesh.Trimesh:
    """The mesh, scaled evenly until its box fits into another one about the origin."""
    low, high = np.asarray(mesh.bounds)
    vertices = (np.asarray(mesh.vertices) - (low + high) / 2) * np.min(size / (high - low))
    return trimesh.Trimesh(vertices, mesh.faces, process=False)


def _within(mesh: trimesh.Trimesh, points: Floats) -> Voxels:
    """Which points lie in a mesh: a ray from there first leaves it."""
    scene = EmbreeScene(robust=True)
    TriangleMesh(scene, mesh.vertices.astype(np.float32), np.array(mesh.faces, dtype=np.int32))
    directions = np.broadcast_to(OBLIQUE, points.shape).astype(np.float32)
    face = scene.run(points.astype(np.float32), directions, output=1)["primID"].astype(np.int64)
    leaving = mesh.face_normals @ OBLIQUE > 0
    return np.asarray((face >= 0) & leaving[face])

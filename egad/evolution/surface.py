"""Voxels -> smooth triangle mesh."""

import trimesh

from egad.errors import RejectedError
from egad.evolution.parameters import Shape
from egad.evolution.voxels import Solid, unpack
from egad.geometry import Smoothing, voxel_surface


def packed_surface(packed: bytes, shape: Shape) -> trimesh.Trimesh:
    """The surface of voxels as archives keep them; `RejectedError` if none is solid."""
    voxels = unpack(packed, shape.resolution)
    if not voxels.any():
        raise RejectedError("no solid voxel")
    return surface(voxels, shape)


def surface(voxels: Solid, shape: Shape) -> trimesh.Trimesh:
    """The smoothed surface of voxels (EGAD, III-B), in metres, its box centered on the origin."""
    smoothing = Smoothing(shape.smoothing_iterations, shape.smoothing_alpha, shape.smoothing_beta)
    _, mesh = voxel_surface(voxels, smoothing)
    low, high = mesh.bounds
    mesh.vertices = (mesh.vertices - (low + high) / 2) * (shape.longest_side / (high - low).max())
    return mesh

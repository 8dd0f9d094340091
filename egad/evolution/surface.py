"""Voxels -> smooth triangle mesh."""

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy import sparse
from skimage.measure import marching_cubes

from egad.errors import RejectedError
from egad.evolution.parameters import Shape
from egad.evolution.voxels import Solid, unpack


def packed_surface(packed: bytes, shape: Shape) -> trimesh.Trimesh:
    """The surface of voxels as archives keep them; see `surface`.

    Raises:
        UserError: Their number does not match the resolution.
        RejectedError: None of them is solid.
    """
    voxels = unpack(packed, shape.resolution)
    if not voxels.any():
        raise RejectedError("no solid voxel")
    return surface(voxels, shape)


def surface(voxels: Solid, shape: Shape) -> trimesh.Trimesh:
    """The surface of a solid: marching cubes, Humphrey smoothing, scaled and centered.

    Source: EGAD, section III-B; smoothing by Vollmer, Mencl, Mueller 1999.

    Args:
        voxels: (r, r, r) bool, not empty.
        shape: Smoothing and size.

    Returns:
        A mesh in metres with outward normals, its axis-aligned box centered on the origin.
    """
    padded = np.pad(voxels, 1).astype(np.float32)
    vertices, faces, _, _ = marching_cubes(padded, 0.5, gradient_direction="ascent")
    mesh = trimesh.Trimesh(vertices.astype(np.float64), faces, process=False)
    trimesh.smoothing.filter_humphrey(
        mesh,
        alpha=shape.smoothing_alpha,
        beta=shape.smoothing_beta,
        iterations=shape.smoothing_iterations,
        laplacian_operator=_neighbor_mean(mesh.faces, len(vertices)),
    )
    low, high = mesh.bounds
    mesh.vertices = (mesh.vertices - (low + high) / 2) * (shape.longest_side / (high - low).max())
    return mesh


def _neighbor_mean(faces: NDArray[np.int64], count: int) -> sparse.csr_matrix:
    """The matrix that replaces each vertex by the mean of its neighbors on a closed surface."""
    pairs = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)  # the other face has the way back
    ones = np.ones(len(pairs))
    adjacency = sparse.csr_matrix((ones, (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    adjacency.data[:] = 1.0  # an edge counts once, however many faces meet there
    return sparse.csr_matrix(adjacency.multiply(1 / adjacency.sum(axis=1)))

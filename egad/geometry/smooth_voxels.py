"""Voxels -> smooth surface, as the objects of the dataset have it."""

import numpy as np
import trimesh
from scipy import sparse
from skimage.measure import marching_cubes

from egad._util.arrays import Flags, Ints, Singles
from egad.geometry.parameters import Smoothing


def voxel_surface(voxels: Flags, smoothing: Smoothing) -> tuple[Singles, trimesh.Trimesh]:
    """Vertices (v, 3) before smoothing, voxel (i, j, k) at (i+1, j+1, k+1), and the smooth mesh.

    Source: EGAD, section III-B; smoothing by Vollmer, Mencl, Mueller 1999.
    """
    padded = np.pad(voxels, 1).astype(np.float32)
    sharp, faces, _, _ = marching_cubes(padded, 0.5, gradient_direction="ascent")
    mesh = trimesh.Trimesh(sharp.astype(np.float64), faces, process=False)
    trimesh.smoothing.filter_humphrey(
        mesh,
        alpha=smoothing.alpha,
        beta=smoothing.beta,
        iterations=smoothing.iterations,
        laplacian_operator=_neighbor_mean(mesh.faces, len(sharp)),
    )
    return sharp, mesh


def _neighbor_mean(faces: Ints, count: int) -> sparse.csr_matrix:
    """The matrix that replaces each vertex by the mean of its neighbors on a closed surface."""
    pairs = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)  # the other face has the way back
    ones = np.ones(len(pairs))
    adjacency = sparse.csr_matrix((ones, (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    adjacency.data[:] = 1.0  # an edge counts once, however many faces meet there
    return sparse.csr_matrix(adjacency.multiply(1 / adjacency.sum(axis=1)))

"""Shape complexity: how unpredictable the curvature of a surface is.

Wang et al., "Assessing shape complexity by the entropy of angular deficits", as used by EGAD
(Morrison, Corke and Leitner, RA-L 2020).
"""

import numpy as np
import trimesh
from numpy.typing import NDArray

from egad._util.kernels import kernel
from egad.geometry import check_mesh
from egad.measures.parameters import BINS

Floats = NDArray[np.float64]


def complexity(mesh: trimesh.Trimesh, bins: int = BINS) -> float:
    """Entropy of the angular deficits of the vertices.

    Args:
        mesh: A triangle mesh of any size; vertices without faces do not count.
        bins: Bins of the histogram over [-2 pi, 2 pi).

    Returns:
        Bits: 0 if all vertices are alike, at most log2(bins).

    Raises:
        RejectedError: The mesh is empty or not finite.
        UserError: It is not a mesh.
    """
    check_mesh(mesh)
    width = 4 * np.pi / bins
    # rounding must not scatter flat vertices, whose deficit 0 is the edge of a bin
    position = (angular_deficits(mesh) + 2 * np.pi) / width + 1e-9
    counts = np.bincount(np.clip(np.floor(position).astype(np.int64), 0, bins - 1))
    share = counts[counts > 0] / counts.sum()
    return float(-np.sum(share * np.log2(share)) + 0.0)


def angular_deficits(mesh: trimesh.Trimesh) -> Floats:
    """2 pi minus the sum of the triangle angles around each vertex that has faces, radians."""
    vertices, faces = np.asarray(mesh.vertices), np.asarray(mesh.faces)
    angles = np.bincount(faces.ravel(), corner_angles(vertices[faces]).ravel(), len(vertices))
    used = np.bincount(faces.ravel(), minlength=len(vertices)) > 0
    return np.asarray(2 * np.pi - angles[used])


@kernel()
def corner_angles(triangles: Floats) -> Floats:
    """Angles at the corners of (n, 3, 3) triangles: (n, 3), radians; 0 between zero edges."""
    result = np.empty((len(triangles), 3))
    for i in range(len(triangles)):
        for corner in range(3):
            after, before = (corner + 1) % 3, (corner + 2) % 3
            cosine = square = 0.0
            for k in range(3):
                j = (k + 1) % 3
                u = triangles[i, after, k] - triangles[i, corner, k]
                v = triangles[i, before, k] - triangles[i, corner, k]
                cosine += u * v
                p = triangles[i, after, j] - triangles[i, corner, j]
                q = triangles[i, before, j] - triangles[i, corner, j]
                square += (u * q - p * v) ** 2
            result[i, corner] = np.arctan2(np.sqrt(square), cosine)
    return result

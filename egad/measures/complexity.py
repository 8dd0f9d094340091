"""Shape complexity: how unpredictable the curvature of a surface is.

Wang et al., "Assessing shape complexity by the entropy of angular deficits", as used by EGAD
(Morrison, Corke and Leitner, RA-L 2020).
"""

import numpy as np
import trimesh

from egad._util.arrays import Floats, Ints
from egad._util.kernels import kernel
from egad.geometry import check_mesh
from egad.geometry.rounding import rounding
from egad.measures.parameters import BINS

UNKNOWN_ROUNDING = 1e-3  # of a bin; away from flat vertices, where evolved objects have few values


def complexity(mesh: trimesh.Trimesh, bins: int = BINS) -> float:
    """Entropy of the angular deficits of the vertices that have faces, bits, at most log2(bins).

    Deficits of flat vertices and right angles are edges of bins; those that rounded coordinates
    moved below count as on it (ours). It depends on the triangles: see `map_complexity`.
    `RejectedError` if the mesh is empty or not finite. Source: EGAD, section III-A.
    """
    check_mesh(mesh)
    width = 4 * np.pi / bins
    deficits = angular_deficits(mesh)
    least = np.where(np.abs(deficits) > width / 2, UNKNOWN_ROUNDING, 1e-9)
    error = np.clip(_deficit_errors(mesh) / width, least, 0.5)
    position = np.floor((deficits + 2 * np.pi) / width + error)
    counts = np.bincount(np.clip(position.astype(np.int64), 0, bins - 1))
    share = counts[counts > 0] / counts.sum()
    return float(-np.sum(share * np.log2(share)) + 0.0)


def angular_deficits(mesh: trimesh.Trimesh) -> Floats:
    """2 pi minus the sum of the triangle angles around each vertex that has faces, radians."""
    vertices, faces = np.asarray(mesh.vertices), np.asarray(mesh.faces)
    return 2 * np.pi - _vertex_sums(faces, corner_angles(vertices[faces]))


def _deficit_errors(mesh: trimesh.Trimesh) -> Floats:
    """How much rounded coordinates may change `angular_deficits`, radians: each, or one for all."""
    vertices, faces = np.asarray(mesh.vertices), np.asarray(mesh.faces)
    moved = rounding(vertices, faces)
    if moved == 0:
        return np.zeros(1)
    triangles = vertices[faces]
    after = np.linalg.norm(np.roll(triangles, -1, axis=1) - triangles, axis=2)
    with np.errstate(divide="ignore"):
        turns = 1 / after + 1 / np.roll(after, 1, axis=1)  # per length that a vertex moves
    return moved * _vertex_sums(faces, turns)


def _vertex_sums(faces: Ints, values: Floats) -> Floats:
    """Sums of values (f, 3) of the corners of faces at each vertex that has faces."""
    used = np.bincount(faces.ravel()) > 0
    return np.asarray(np.bincount(faces.ravel(), values.ravel())[used])


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

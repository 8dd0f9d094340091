"""Shape complexity: how unpredictable the curvature of a surface is.

Wang et al., "Assessing shape complexity by the entropy of angular deficits", as used by EGAD
(Morrison, Corke and Leitner, RA-L 2020).
"""

import numpy as np
import trimesh
from numpy.typing import ArrayLike, NDArray

from egad._util.arrays import Floats
from egad._util.kernels import kernel
from egad.geometry import check_mesh, distinct_corners, refine, triangulation
from egad.geometry.rounding import rounding
from egad.measures.parameters import BINS

UNKNOWN_ROUNDING = 1e-3  # of a bin; away from flat vertices, where evolved objects have few values
LONG_EDGE = 0.08  # over the square root of the area: as on 99 % of the released objects
MAX_SPLITS = 20_000
CELL_WIDTH = 0.16  # bits, of the usual map


class CoarseMeshWarning(UserWarning):
    """A mesh has such long edges that its complexity reflects its triangles more than its shape."""


def complexity(mesh: trimesh.Trimesh, bins: int = BINS) -> float:
    """Entropy of the angular deficits of the vertices.

    Flat vertices and right angles lie on the edge of a bin. A deficit that rounded coordinates have
    moved below the edge counts as if it were on it. So the number of digits in a file does not
    matter.

    Args:
        mesh: A triangle mesh of any size; vertices without faces do not count.
        bins: Bins of the histogram over [-2 pi, 2 pi).

    Returns:
        Bits: 0 if all vertices are alike, at most log2(bins).

    Raises:
        RejectedError: The mesh is empty or not finite.
        UserError: It is not a mesh.

    Source: EGAD, section III-A; the treatment of rounding is ours.
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


def fine_complexity(mesh: trimesh.Trimesh, bins: int = BINS) -> float:
    """Complexity of a mesh after splitting its long edges, which does not change its shape.

    The vertices of evolved objects are close together and evenly spaced. Their complexity can be
    compared only with that of meshes with similar triangles.

    Args:
        mesh: A triangle mesh of any size.
        bins: Bins of the histogram over [-2 pi, 2 pi).

    Returns:
        Bits. It equals the complexity if no edge is longer than 8 % of the square root of the
        area. If it differs from the complexity, neither is meaningful: see `is_coarse`.

    Raises:
        RejectedError: The mesh is empty or not finite.
        UserError: It is not a mesh.

    Source: ours.
    """
    check_mesh(mesh)
    edges = triangulation(np.asarray(mesh.vertices), distinct_corners(np.asarray(mesh.faces)))
    longest = LONG_EDGE * np.sqrt(mesh.area)
    fine = refine(edges, len(mesh.vertices) + MAX_SPLITS, longest)
    return complexity(trimesh.Trimesh(fine.vertices, fine.faces, process=False), bins)


def is_coarse(complexities: ArrayLike, fine_complexities: ArrayLike) -> NDArray[np.bool_]:
    """Whether meshes are too coarse, (n,): splitting long edges moves them by more than a cell."""
    change = np.asarray(fine_complexities, float) - np.asarray(complexities, float)
    return np.asarray(np.abs(change) > CELL_WIDTH)


def coarse_advice(fine: float) -> str:
    """What the user of a mesh that is too coarse should know and do."""
    return (
        f"the triangles are too large for a meaningful complexity ({fine:.3f} bits after long "
        "edges are split): remesh with uniform edges of about 2 % of the longest side"
    )


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


def _vertex_sums(faces: NDArray[np.int64], values: Floats) -> Floats:
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

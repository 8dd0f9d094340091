"""Rounded coordinates: how far they moved vertices, and rounding to single precision.

STL, PLY and GLB files hold single-precision numbers, and so do most programs that read OBJ. A mesh
with such coordinates is bit-identical in all formats and programs, as long as they keep its unit.
"""

import numpy as np
import trimesh
from numpy.typing import ArrayLike

from egad._util.arrays import Floats, Ints
from egad._util.kernels import kernel
from egad.geometry.refinement import Triangulation, distinct_corners, face_areas, triangulation

MAX_ROUNDING = 1e-4  # largest rounding considered, over the square root of the area
USUAL = 5e-6  # over the same: rounding of files, which leaves planes parallel to the axes flat
GAP = 10.0  # flat folds and real ones differ in height by at least this factor,
STRAY = 0.05  # except for a few: this many per flat fold
FLAT = 0.15  # smallest fraction of flat folds that tells rounding from chance


def rounding(vertices: Floats, faces: Ints) -> float:
    """Estimate how far rounded coordinates may have moved vertices, from faces in one plane (ours).

    A fold of two faces in one plane has the height 0, or about the rounding, far below real folds.
    The estimate is the largest height with such a gap above, or the usual rounding of files, which
    leaves planes parallel to the axes flat; 0 if few folds are flat, or if there is no gap.
    """
    mesh = triangulation(np.ascontiguousarray(vertices), distinct_corners(faces))
    areas = face_areas(mesh)
    largest = MAX_ROUNDING * np.sqrt(areas.sum())
    heights = fold_heights(mesh, areas)
    least = FLAT * np.count_nonzero(np.isfinite(heights))
    heights = np.sort(heights[heights <= GAP * largest])
    lower = np.searchsorted(heights, heights, side="right")
    stray = np.searchsorted(heights, GAP * heights, side="right") - lower
    flat = (heights <= largest) & (lower >= least) & (stray <= STRAY * lower)
    if not flat.any():
        return 0.0
    return float(max(heights[flat].max(), USUAL * np.sqrt(areas.sum())))


@kernel()
def fold_heights(mesh: Triangulation, areas: Floats) -> Floats:
    """Height of the fold at each edge, (e,), over its larger face; infinite at a rim."""
    first = np.full(len(mesh.edges), -1)
    result = np.full(len(mesh.edges), np.inf)
    for corner in range(3 * len(mesh.faces)):
        edge = mesh.face_edges[corner // 3, corner % 3]
        if first[edge] < 0:
            first[edge] = corner
            continue
        one, other = first[edge] // 3, corner // 3
        area = max(areas[one], areas[other])
        if result[edge] == np.inf and area > 0:
            a, b, c = mesh.faces[one]
            tip = mesh.faces[other, (corner % 3 + 2) % 3]
            volume = 0.0  # six times that of the tetrahedron of both faces
            for k in range(3):
                i, j = (k + 1) % 3, (k + 2) % 3
                normal = (mesh.vertices[b, i] - mesh.vertices[a, i]) * (
                    mesh.vertices[c, j] - mesh.vertices[a, j]
                ) - (mesh.vertices[b, j] - mesh.vertices[a, j]) * (
                    mesh.vertices[c, i] - mesh.vertices[a, i]
                )
                volume += normal * (mesh.vertices[tip, k] - mesh.vertices[a, k])
            result[edge] = abs(volume) / (2 * area)
    return result


def to_single(coordinates: ArrayLike) -> Floats:
    """Coordinates rounded to single precision, as doubles; infinite where they are too large."""
    with np.errstate(over="ignore"):
        return np.asarray(coordinates, dtype=np.float32).astype(np.float64)


def is_single(coordinates: ArrayLike) -> bool:
    """Whether rounding to single precision changes nothing."""
    return bool(np.array_equal(to_single(coordinates), np.asarray(coordinates)))


def in_single_precision(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """A copy of a mesh with coordinates rounded to single precision, and the same faces."""
    return trimesh.Trimesh(to_single(mesh.vertices), mesh.faces, process=False)

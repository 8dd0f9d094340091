"""How far the rounding of coordinates has moved the vertices of a mesh."""

import numpy as np
from numpy.typing import NDArray

from egad._util.arrays import Floats
from egad._util.kernels import kernel
from egad.geometry.refinement import Triangulation, distinct_corners, face_areas, triangulation

MAX_ROUNDING = 1e-4  # largest rounding considered, over the square root of the area
USUAL = 5e-6  # over the same: rounding of files, which leaves planes parallel to the axes flat
GAP = 10.0  # flat folds and real ones differ in height by at least this factor,
STRAY = 0.05  # except for a few: this many per flat fold
FLAT = 0.15  # smallest fraction of flat folds that tells rounding from chance


def rounding(vertices: Floats, faces: NDArray[np.int64]) -> float:
    """Estimate how far rounded coordinates may have moved vertices, from faces in one plane (ours).

    Two faces that share an edge form a fold. If they lie in one plane, the height of the fold is 0,
    and rounded coordinates make it about as large as the rounding, far below the heights of real
    folds. The estimate is the largest height with such a gap above it, or the usual rounding of
    files, which also moves corners where it leaves planes parallel to the axes flat. It is 0 if few
    folds are flat, or if heights have no gap, as on the smooth surfaces of evolved objects.
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

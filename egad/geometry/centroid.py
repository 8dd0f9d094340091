"""The center of mass of a mesh, quickly."""

import numpy as np
import trimesh

from egad._util.arrays import Floats
from egad._util.kernels import kernel
from egad.geometry.rays import bounding_box


def center_of_mass(mesh: trimesh.Trimesh) -> Floats:
    """The centroid of the volume; that of the surface if the former is not within the bounds."""
    triangles = np.asarray(mesh.vertices)[mesh.faces]
    center = _volume_centroid(triangles)
    low, high = bounding_box(triangles)
    inside = bool(np.all((center >= low) & (center <= high)))  # False for NaN
    return center if inside else np.asarray(mesh.centroid)


@kernel()
def _volume_centroid(triangles: Floats) -> Floats:
    """Centroid of a solid from triangles (n, 3, 3), without the inertia tensor, for speed."""
    moment, volume = np.zeros(3), 0.0
    a, b, c = np.empty(3), np.empty(3), np.empty(3)
    for i in range(len(triangles)):
        for k in range(3):  # from the first corner, for precision far from the origin
            start = triangles[0, 0, k]
            a[k], b[k] = triangles[i, 0, k] - start, triangles[i, 1, k] - start
            c[k] = triangles[i, 2, k] - start
        six_volumes = 0.0
        for k in range(3):
            m, n = (k + 1) % 3, (k + 2) % 3
            six_volumes += a[k] * (b[m] * c[n] - b[n] * c[m])
        volume += six_volumes
        for k in range(3):
            moment[k] += six_volumes * (a[k] + b[k] + c[k])
    center: Floats = triangles[0, 0] + moment / (4 * volume)
    return center

"""Points spread evenly over a surface."""

from typing import NamedTuple

import numpy as np
import trimesh
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class Samples(NamedTuple):
    """Points, (n, 3), the outward unit normals there, and the triangles they lie on, (n,)."""

    points: Floats
    normals: Floats
    faces: Ints


def spread(mesh: trimesh.Trimesh, spacing: float) -> Samples:
    """The middles of the pieces of all triangles, halved until no side exceeds the spacing.

    Args:
        mesh: A surface, wound outwards; triangles without area have no normal and no samples.
        spacing: In the unit of the mesh.
    """
    owners = np.flatnonzero(np.asarray(mesh.area_faces) > 0)
    pieces = np.asarray(mesh.triangles)[owners]
    middles, faces = [], []
    while len(pieces):
        sides = np.linalg.norm(np.roll(pieces, -1, axis=1) - pieces, axis=2)
        small = sides.max(axis=1) <= spacing
        middles.append(pieces[small].mean(axis=1))
        faces.append(owners[small])
        pieces, owners = _halves(pieces[~small], sides[~small]), np.tile(owners[~small], 2)
    found = np.concatenate(faces)
    return Samples(np.concatenate(middles), np.asarray(mesh.face_normals)[found], found)


def _halves(triangles: Floats, sides: Floats) -> Floats:
    """Triangles cut in two from the middle of their longest side, (2n, 3, 3)."""
    longest = sides.argmax(axis=1)
    each = np.arange(len(triangles))
    start, end, tip = (triangles[each, (longest + corner) % 3] for corner in range(3))
    middle = (start + end) / 2
    halves = [np.stack([start, middle, tip], axis=1), np.stack([middle, end, tip], axis=1)]
    return np.concatenate(halves)

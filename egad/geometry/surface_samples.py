"""Points spread evenly over a surface."""

from typing import NamedTuple

import numpy as np
import trimesh

from egad._util.arrays import Floats, Ints


class Samples(NamedTuple):
    """Points, (n, 3), the outward unit normals there, and the triangles they lie on, (n,)."""

    points: Floats
    normals: Floats
    faces: Ints


def spread(mesh: trimesh.Trimesh, spacing: float) -> Samples:
    """The centers of all triangles, after halving them until no side exceeds the spacing."""
    owners = np.flatnonzero(np.asarray(mesh.area_faces) > 0)
    # corners, axes, triangles: operations on all triangles run over contiguous numbers
    pieces = np.ascontiguousarray(np.asarray(mesh.triangles)[owners].transpose(1, 2, 0))
    middles, faces = [], []
    while len(owners):
        sides = _sides(pieces)
        small = sides.max(axis=0) <= spacing
        done, left = np.flatnonzero(small), np.flatnonzero(~small)
        a, b, c = np.take(pieces, done, axis=2)
        middles.append((a + b + c) / 3)
        faces.append(owners[done])
        pieces, owners = _halves(pieces[..., left], sides[:, left]), np.tile(owners[left], 2)
    found = np.concatenate(faces)
    points = np.ascontiguousarray(np.concatenate(middles, axis=1).T)
    return Samples(points, np.asarray(mesh.face_normals)[found], found)


def _sides(triangles: Floats) -> Floats:
    """Lengths of the sides of triangles (3, 3, n), the first from the first corner on: (3, n)."""
    a, b, c = triangles
    steps = (b - a, c - b, a - c)
    return np.stack([np.sqrt(x * x + y * y + z * z) for x, y, z in steps])


def _halves(triangles: Floats, sides: Floats) -> Floats:
    """Triangles (3, 3, n) cut in two from the middle of their longest side, (3, 3, 2n)."""
    longest = sides.argmax(axis=0)
    each = np.arange(len(longest))
    start, end, tip = (triangles[(longest + corner) % 3, :, each].T for corner in range(3))
    middle = (start + end) / 2
    corners = ((start, middle), (middle, end), (tip, tip))
    return np.stack([np.concatenate(pair, axis=1) for pair in corners])

"""Polygons of mesh files, cut into triangles that lie within them."""

from collections.abc import Sequence

import manifold3d
import numpy as np
import trimesh
from numpy.typing import NDArray

from egad._util.input_limits import MAX_FACES, check_at_most
from egad.errors import RejectedError

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def triangles_of(vertices: Floats, corners: Ints, lengths: Ints) -> Ints:
    """Triangles of polygons, in their order; (m, 3) vertex indices.

    A polygon is cut by diagonals from its first corner where that is right, as it is for all
    convex ones. Others are triangulated in their mean plane. Polygons of one or two corners have no
    area: they are points and edges, which are left out.

    Args:
        vertices: (n, 3).
        corners: Vertex indices of all polygons, one polygon after the other; (k,).
        lengths: How many corners each polygon has.

    Raises:
        RejectedError: There are more triangles than are read, a corner does not exist, or a
            polygon crosses itself.
    """
    check_at_most(int(np.maximum(lengths - 2, 0).sum()), MAX_FACES, "faces")
    check_corners(corners, len(vertices))
    starts = np.cumsum(lengths) - lengths
    parts: list[Ints] = [np.empty((0, 3), np.int64)]
    origins: list[Ints] = [np.empty(0, np.int64)]
    for length in np.unique(lengths[lengths >= 3]).tolist():
        which = np.flatnonzero(lengths == length)
        polygons = corners[starts[which, None] + np.arange(length)]
        parts.append(_cut(vertices, polygons).reshape(-1, 3))
        origins.append(np.repeat(which, length - 2))
    order = np.argsort(np.concatenate(origins), kind="stable")
    return np.concatenate(parts)[order]


def check_corners(corners: Ints, count: int) -> None:
    """Make sure that faces have vertices that exist.

    Raises:
        RejectedError: They have others.
    """
    if corners.size and (corners.min() < 0 or corners.max() >= count):
        raise RejectedError("faces refer to vertices that do not exist")


def strip_triangles(strip: Ints) -> Ints:
    """Triangles of a strip, which turn by turns; those that only link two parts are left out."""
    rows = np.column_stack([strip[:-2], strip[1:-1], strip[2:]])
    rows[1::2] = rows[1::2, [1, 0, 2]]
    a, b, c = rows.T
    triangles: Ints = rows[(a != b) & (b != c) & (c != a)]
    return triangles


def _cut(vertices: Floats, polygons: Ints) -> Ints:
    """Triangles of polygons (p, k) of the same number of corners, (p, k - 2, 3)."""
    length = polygons.shape[1]
    first = np.repeat(polygons[:, :1], length - 2, axis=1)
    triangles = np.stack([first, polygons[:, 1:-1], polygons[:, 2:]], axis=2)
    if length == 3:
        return triangles
    a, b, c = np.moveaxis(vertices[triangles], 2, 0)
    normals = np.cross(b - a, c - a)
    means = normals.sum(axis=1)
    facing = np.einsum("pij,pj->pi", normals, means)
    for each in np.flatnonzero((facing <= 0).any(axis=1)):
        if means[each].any():
            triangles[each] = polygons[each, _seen_along(means[each], vertices[polygons[each]])]
    return triangles


def _seen_along(normal: Floats, corners: Floats) -> Ints:
    """Triangles between the corners (k, 3) of a polygon, as it is seen along its normal."""
    to_plane = trimesh.geometry.align_vectors(normal, [0, 0, 1])
    flat = (corners - corners.mean(axis=0)) @ to_plane[:3, :3].T
    found = np.asarray(manifold3d.triangulate([np.ascontiguousarray(flat[:, :2])]))
    if len(found) != len(corners) - 2:
        raise RejectedError("a polygon crosses itself")
    return found.astype(np.int64)


def fan_triangles(fan: Sequence[int] | Ints) -> Ints:
    """Triangles around the first of some vertices, (n - 2, 3)."""
    ring = np.asarray(fan)
    return np.column_stack([np.full(max(len(ring) - 2, 0), ring[:1]), ring[1:-1], ring[2:]])

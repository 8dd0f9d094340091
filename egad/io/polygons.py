"""What mesh files hold: triangles, and polygons that are cut into triangles within them."""

from typing import NamedTuple

import manifold3d
import numpy as np
import trimesh

from egad._util.arrays import Floats, Ints
from egad._util.input_limits import MAX_FACES, check_at_most
from egad.errors import RejectedError

ROUNDING = 1e-6  # of areas of polygons of size 1


class Content(NamedTuple):
    """A surface of triangles, in the unit of the file and in the axes of its format."""

    vertices: Floats  # (n, 3)
    faces: Ints  # (m, 3) vertex indices
    unit: str | None = None  # one of `egad.io.units.LENGTHS`, if the file states it


def triangles_of(vertices: Floats, corners: Ints, lengths: Ints) -> Ints:
    """Triangles (m, 3) of polygons of (k,) corners, cut from the first or in the mean plane."""
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
    """Raise `RejectedError` if faces have vertices that do not exist."""
    if corners.size and (corners.min() < 0 or corners.max() >= count):
        raise RejectedError("faces refer to vertices that do not exist")


def strip_triangles(strip: Ints) -> Ints:
    """Triangles of a strip, which wind alternately; those that only link two parts are left out."""
    rows = np.column_stack([strip[:-2], strip[1:-1], strip[2:]])
    rows[1::2] = rows[1::2, [1, 0, 2]]
    a, b, c = rows.T
    return np.asarray(rows[(a != b) & (b != c) & (c != a)])


def _cut(vertices: Floats, polygons: Ints) -> Ints:
    """Triangles of polygons (p, k) of the same number of corners, (p, k - 2, 3)."""
    length = polygons.shape[1]
    triangles = fan_triangles(polygons)
    if length == 3:
        return triangles
    a, b, c = np.moveaxis(vertices[triangles], 2, 0)
    normals = np.cross(b - a, c - a)
    means = normals.sum(axis=1)
    areas = np.linalg.norm(normals, axis=2)
    facing = np.einsum("pij,pj->pi", normals, means)
    for each in np.flatnonzero((facing <= 0).any(axis=1) & areas.any(axis=1)):
        normal, most = means[each], areas[each].argmax()
        if np.linalg.norm(normal) < 1e-9 * areas[each, most]:
            normal = normals[each, most]  # both sides are seen alike
        triangles[each] = polygons[each, _seen_along(normal, vertices[polygons[each]])]
    return triangles


def _seen_along(normal: Floats, corners: Floats) -> Ints:
    """Triangles between the corners (k, 3) of a polygon, as it is seen along its normal."""
    to_plane = trimesh.geometry.align_vectors(normal, [0, 0, 1])
    flat = ((corners - corners.mean(axis=0)) @ to_plane[:3, :3].T)[:, :2]
    flat = np.ascontiguousarray(flat / np.abs(flat).max())
    found = np.asarray(manifold3d.triangulate([flat])).astype(np.int64)
    if (np.linalg.det(np.diff(flat[found], axis=1)) < -ROUNDING).any():
        raise RejectedError("a polygon crosses itself")
    return found


def fan_triangles(corners: Ints) -> Ints:
    """Triangles around the first of some corners (..., k): (..., k - 2, 3)."""
    first = np.broadcast_to(corners[..., :1], corners[..., 2:].shape)
    return np.stack([first, corners[..., 1:-1], corners[..., 2:]], axis=-1)

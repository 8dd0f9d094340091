"""Exact test of boxes against triangles, for a body of boxes that turns about an axis."""

import numba
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]


def blocked_turns(
    triangles: Floats, boxes: Floats, origins: Floats, frames: Floats, turns: Floats
) -> Flags:
    """In which poses a body of boxes touches a surface.

    Args:
        triangles: (m, 3, 3), metres.
        boxes: (b, 2, 3) low and high corners of the boxes in the frame of the body, metres.
        origins: (n, 3) origins of that frame, metres.
        frames: (n, 3, 3) its unit vectors x, y, z in rows.
        turns: (k,) angles that the body turns about x, taking z towards -y, radians.

    Returns:
        (n, k): whether any box touches any triangle.
    """
    centers = triangles.mean(axis=1)
    radii = np.linalg.norm(triangles - centers[:, None], axis=2).max(axis=1)
    # nearest that a box comes to the axis: no turn brings it nearer
    gaps = np.linalg.norm(np.maximum(np.maximum(boxes[:, 0], -boxes[:, 1]), 0)[:, 1:], axis=1)
    result: Flags = _blocked_turns(
        np.ascontiguousarray(triangles),
        np.ascontiguousarray(centers),
        radii,
        np.ascontiguousarray(boxes),
        gaps,
        np.ascontiguousarray(origins),
        np.ascontiguousarray(frames),
        np.cos(turns),
        np.sin(turns),
    )
    return result


@numba.njit(cache=True)
def _blocked_turns(
    triangles: Floats,
    centers: Floats,
    radii: Floats,
    boxes: Floats,
    gaps: Floats,
    origins: Floats,
    frames: Floats,
    cosines: Floats,
    sines: Floats,
) -> Flags:
    result = np.zeros((len(origins), len(cosines)), np.bool_)
    turned = np.empty((3, 3))
    for n in range(len(origins)):
        for m in range(len(triangles)):
            x, y, z = _local(centers, m, origins, frames, n)
            radius, outward = radii[m], np.sqrt(y * y + z * z)
            for b in range(len(boxes)):
                if _apart(x, radius, boxes, b, 0) or outward + radius < gaps[b]:
                    continue
                for k in range(len(cosines)):
                    turned_y = cosines[k] * y + sines[k] * z
                    if result[n, k] or _apart(turned_y, radius, boxes, b, 1):
                        continue
                    turned_z = cosines[k] * z - sines[k] * y
                    if _apart(turned_z, radius, boxes, b, 2):
                        continue
                    for i in range(3):
                        p, q, r = _local(triangles[m], i, origins, frames, n)
                        turned[i, 0] = p
                        turned[i, 1] = cosines[k] * q + sines[k] * r
                        turned[i, 2] = cosines[k] * r - sines[k] * q
                    result[n, k] = box_meets_triangle(turned, boxes[b])
    return result


@numba.njit(cache=True)
def _apart(middle: float, radius: float, boxes: Floats, b: int, axis: int) -> bool:
    return bool(middle + radius < boxes[b, 0, axis] or middle - radius > boxes[b, 1, axis])


@numba.njit(cache=True)
def _local(
    points: Floats, i: int, origins: Floats, frames: Floats, n: int
) -> tuple[float, float, float]:
    """Point i in frame n."""
    x = points[i, 0] - origins[n, 0]
    y = points[i, 1] - origins[n, 1]
    z = points[i, 2] - origins[n, 2]
    return (
        frames[n, 0, 0] * x + frames[n, 0, 1] * y + frames[n, 0, 2] * z,
        frames[n, 1, 0] * x + frames[n, 1, 1] * y + frames[n, 1, 2] * z,
        frames[n, 2, 0] * x + frames[n, 2, 1] * y + frames[n, 2, 2] * z,
    )


@numba.njit(cache=True)
def box_meets_triangle(triangle: Floats, box: Floats) -> bool:
    """Whether a triangle (3, 3) and a box (low and high corner) share a point: separating axes."""
    half = (box[1] - box[0]) / 2
    corners = triangle - (box[1] + box[0]) / 2
    for axis in range(3):
        if corners[:, axis].min() > half[axis] or corners[:, axis].max() < -half[axis]:
            return False
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    if abs(np.dot(normal, corners[0])) > np.dot(np.abs(normal), half):
        return False
    for i in range(3):
        edge = corners[(i + 1) % 3] - corners[i]
        other = corners[(i + 2) % 3]
        for axis in range(3):
            u, v = (axis + 1) % 3, (axis + 2) % 3
            # the separating direction is the axis crossed with the edge: -edge[v], edge[u]
            first = edge[u] * corners[i, v] - edge[v] * corners[i, u]
            second = edge[u] * other[v] - edge[v] * other[u]
            size = half[u] * abs(edge[v]) + half[v] * abs(edge[u])
            if min(first, second) > size or max(first, second) < -size:
                return False
    return True

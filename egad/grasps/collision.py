"""Collision of a hand that turns about an axis: exact test of convex parts against triangles."""

from collections.abc import Sequence

import numpy as np

from egad._util.arrays import Flags, Floats, Ints
from egad._util.kernels import kernel
from egad.grippers import Gripper, Part

TABLE_CLEARANCE = 0.003  # fingertips stay this far above whatever lies below them
SIDE_CLEARANCE = 0.008  # free space wanted on each side of the held object
# The same in front of a fixed jaw, if only an image tells where the object is: the other jaw pushes
# the object by as much as is left.
FIXED_SIDE_CLEARANCE = 0.003
MIN_DEPTH = 0.003  # the fingertips reach at least this far below the contacts


def roomy(distance: Floats, gripper: Gripper) -> Floats:
    """How far to open for contacts this far apart: 8 mm more on each side, if the hand can."""
    width: Floats = np.minimum(distance + 2 * SIDE_CLEARANCE, gripper.opening)
    return width


def expected_distance(opening: float, gripper: Gripper) -> float | None:
    """The contact distance for which `roomy` gives an opening; None for the widest, metres."""
    if opening >= gripper.opening:
        return None
    return max(opening - 2 * SIDE_CLEARANCE, 0.0)


def blocked_turns(
    triangles: Floats,  # (m, 3, 3), metres
    parts: Sequence[Part],  # of the body, in its frame
    origins: Floats,  # (n, 3) of that frame, metres
    frames: Floats,  # (n, 3, 3) its unit vectors x, y, z in rows
    turns: Floats,  # (k,) angles that the body turns about x, taking z towards -y, radians
    known: Flags | None = None,  # (n, k) poses that are known to touch, and not tested
    behind: Floats | None = None,  # (n,) metres by which the body lies behind its frame, along -z
) -> Flags:
    """In which poses a body touches a surface, (n, k)."""
    centers, radii = spheres(triangles)
    boxes = np.stack([part.box for part in parts])
    behind = np.zeros(len(origins)) if behind is None else behind
    # smallest distance of each box from the axis: no turn brings it nearer
    ends = boxes.copy()
    ends[:, :, 2] -= behind.max(initial=0.0), behind.min(initial=0.0)
    gaps = np.linalg.norm(np.maximum(np.maximum(ends[:, 0], -ends[:, 1]), 0)[:, 1:], axis=1)
    shape = (len(origins), len(turns))
    result = np.zeros(shape, dtype=bool) if known is None else known.copy()
    _block_turns(
        np.ascontiguousarray(triangles),
        centers,
        radii,
        boxes,
        gaps,
        np.concatenate([part.planes for part in parts]),
        np.cumsum([0, *(len(part.planes) for part in parts)]),
        np.ascontiguousarray(origins),
        np.ascontiguousarray(frames),
        np.cos(turns),
        np.sin(turns),
        behind,
        result,
    )
    return result


def spheres(triangles: Floats) -> tuple[Floats, Floats]:
    """Centers (m, 3) and radii (m,) of spheres around triangles."""
    centers = triangles.mean(axis=1)
    radii = np.linalg.norm(triangles - centers[:, None], axis=2).max(axis=1)
    return np.ascontiguousarray(centers), radii


@kernel()
def _block_turns(
    triangles: Floats,
    centers: Floats,
    radii: Floats,
    boxes: Floats,
    gaps: Floats,
    planes: Floats,
    bounds: Ints,
    origins: Floats,
    frames: Floats,
    cosines: Floats,
    sines: Floats,
    behind: Floats,
    result: Flags,
) -> None:
    turned = np.empty((3, 3))
    for n in range(len(origins)):
        left = len(cosines) - result[n].sum()
        for m in range(len(triangles) if left else 0):
            x, y, z = local(centers, m, origins, frames, n)
            radius, outward = radii[m], np.sqrt(y * y + z * z)
            for b in range(len(boxes)):
                if apart(x, radius, boxes[b], 0) or outward + radius < gaps[b]:
                    continue
                for k in range(len(cosines)):
                    turned_y = cosines[k] * y + sines[k] * z
                    if result[n, k] or apart(turned_y, radius, boxes[b], 1):
                        continue
                    turned_z = cosines[k] * z - sines[k] * y + behind[n]
                    if apart(turned_z, radius, boxes[b], 2):
                        continue
                    for i in range(3):
                        p, q, r = local(triangles[m], i, origins, frames, n)
                        turned[i, 0] = p
                        turned[i, 1] = cosines[k] * q + sines[k] * r
                        turned[i, 2] = cosines[k] * r - sines[k] * q + behind[n]
                    if _touches(turned, boxes[b], planes, bounds[b], bounds[b + 1]):
                        result[n, k] = True
                        left -= 1


@kernel()
def _touches(triangle: Floats, box: Floats, planes: Floats, first: int, end: int) -> bool:
    """Whether a triangle meets the part with this box and planes `first` to `end`, if any."""
    if not box_meets_triangle(triangle, box):
        return False
    if first == end:
        return True
    for i in range(first, end):
        plane = planes[i]
        low = min(_height(plane, triangle[0]), _height(plane, triangle[1]))
        if min(low, _height(plane, triangle[2])) > 0:
            return False
    return bool(clipped(triangle, planes[first:end])[1] > 0)


@kernel()
def apart(middle: float, radius: float, box: Floats, axis: int) -> bool:
    """Whether a sphere misses a box along one axis."""
    return bool(middle + radius < box[0, axis] or middle - radius > box[1, axis])


@kernel()
def local(
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


@kernel()
def clipped(polygon: Floats, planes: Floats) -> tuple[Floats, int]:
    """Corners of a convex polygon left behind planes (Sutherland and Hodgman 1974); how many."""
    count = len(polygon)
    corners = np.empty((count + len(planes) + 1, 3))
    kept = np.empty((count + len(planes) + 1, 3))
    corners[:count] = polygon
    for plane in planes:
        left = 0
        previous = corners[count - 1]
        before = _height(plane, previous)
        for i in range(count):
            current = corners[i]
            height = _height(plane, current)
            if height * before < 0:
                part = before / (before - height)
                for j in range(3):
                    kept[left, j] = previous[j] + part * (current[j] - previous[j])
                left += 1
            if height <= 0:
                kept[left] = current
                left += 1
            previous, before = current, height
        corners, kept, count = kept, corners, left
        if count == 0:
            break
    return corners, count


@kernel()
def _height(plane: Floats, point: Floats) -> float:
    return float(plane[0] * point[0] + plane[1] * point[1] + plane[2] * point[2] + plane[3])


@kernel()
def box_meets_triangle(triangle: Floats, box: Floats) -> bool:
    """Whether a triangle (3, 3) and a box (low and high corner) share a point: separating axes."""
    if _corner_within(triangle, box):
        return True
    half, corners, normal = np.empty(3), np.empty((3, 3)), np.empty(3)
    for axis in range(3):
        half[axis] = (box[1, axis] - box[0, axis]) / 2
        middle = (box[1, axis] + box[0, axis]) / 2
        low, high = np.inf, -np.inf
        for i in range(3):
            corners[i, axis] = triangle[i, axis] - middle
            low, high = min(low, corners[i, axis]), max(high, corners[i, axis])
        if low > half[axis] or high < -half[axis]:
            return False
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        normal[axis] = (corners[1, u] - corners[0, u]) * (corners[2, v] - corners[0, v]) - (
            corners[1, v] - corners[0, v]
        ) * (corners[2, u] - corners[0, u])
    if abs(np.dot(normal, corners[0])) > np.dot(np.abs(normal), half):
        return False
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        for axis in range(3):
            u, v = (axis + 1) % 3, (axis + 2) % 3
            # the separating direction is the axis crossed with the edge: -edge[v], edge[u]
            along_u, along_v = corners[j, u] - corners[i, u], corners[j, v] - corners[i, v]
            first = along_u * corners[i, v] - along_v * corners[i, u]
            second = along_u * corners[k, v] - along_v * corners[k, u]
            size = half[u] * abs(along_v) + half[v] * abs(along_u)
            if min(first, second) > size or max(first, second) < -size:
                return False
    return True


@kernel()
def _corner_within(triangle: Floats, box: Floats) -> bool:
    for i in range(3):
        within = True
        for axis in range(3):
            within &= box[0, axis] <= triangle[i, axis] <= box[1, axis]
        if within:
            return True
    return False

"""How close hulls must be to the touchable surface, and how to bring them closer."""

from itertools import count
from typing import NamedTuple

import numpy as np
import trimesh

from egad._util.arrays import Flags
from egad.geometry.hulls import Hull, fewer_vertices, hull_of, lower_planes
from egad.geometry.touchable import (
    MAX_BURIED,
    Touchable,
    deeper_points,
    depths,
    facing_depths,
    share_within,
    touchable_points,
    within_box,
)

# Fractions of the allowed deviation:
DEPTH = 0.8  # of points in the end; those between them may lie a little deeper
LOWERING = 0.8  # at most, of faces that bridge a hollow
NEIGHBORS = 0.3  # faces this much deeper above a point than the nearest are lowered too
# Losses by leaving out corners, as fractions of the allowed deviation and volume error:
LOSS = (1.0, 0.5)  # to meet the limit on the number of vertices
FINAL_LOSS = (0.5, 0.25)  # in the end, even if more vertices are allowed
BURIED = 0.005  # of the points of a common hull, at most
CHECKED = 0.8  # of the share that may be buried: other points may show a little more
REFITS = 3  # to twice as many points and more, before the bounds are loosened
STEP = 2**0.5  # the bounds are loosened by this factor, again and again


class Tolerances(NamedTuple):
    """How far parts may be from a solid."""

    deviation: float  # metres, of the touchable surface
    volume_error: float  # relative
    max_vertices: int  # maximum number of vertices of a part
    lowering: float  # by how much faces may be moved inwards, metres

    def loosened(self, factor: float) -> "Tolerances":
        """Looser bounds, but only for outward errors: faces are not moved further inwards."""
        deviation, volume_error = factor * self.deviation, factor * self.volume_error
        return self._replace(deviation=deviation, volume_error=volume_error)

    def can_be_reduced(self, hull: Hull) -> bool:
        """Whether a hull keeps its shape with few enough corners."""
        return len(hull.points) <= self.max_vertices or self.reduced(hull, LOSS)[1]

    def reduced(self, hull: Hull, loss: tuple[float, float]) -> tuple[Hull, bool]:
        """A hull without the corners that matter least, and whether the loss is within bounds."""
        distance, share = loss[0] * self.deviation, loss[1] * self.volume_error
        return fewer_vertices(hull, self.max_vertices, distance, share)


def too_deep(touchable: Touchable, hull: Hull, tolerances: Tolerances) -> Flags:
    """Which of n points would lie too deep in a hull even if its faces were lowered, (n,)."""
    if not len(hull.planes):
        return np.zeros(len(touchable.points), dtype=np.bool_)
    limit = DEPTH * tolerances.deviation
    most = limit + tolerances.lowering
    return np.asarray(deeper_points(*touchable, hull.planes, limit, most))


def fits(hull: Hull, touchable: Touchable, tolerances: Tolerances) -> bool:
    """Whether a hull may be a part: it buries few points, and has few enough vertices."""
    near = touchable.where(within_box(touchable.points, hull.points))
    buried = int(too_deep(near, hull, tolerances).sum())
    if buried:
        inside = depths(near.points, hull.planes) > -tolerances.deviation
        if buried > BURIED * inside.sum():
            return False
    return tolerances.can_be_reduced(hull)


def lower_faces(hull: Hull, touchable: Touchable, tolerances: Tolerances) -> Hull:
    """A hull with its faces moved inwards where they bridge a hollow: halves the parts (ours)."""
    planes, limit, most = hull.planes, DEPTH * tolerances.deviation, tolerances.lowering
    near = touchable.where(within_box(touchable.points, hull.points))
    below = facing_depths(near.where(depths(near.points, planes) > limit), planes)
    nearest = below.min(axis=1, keepdims=True)
    concerned = (below <= nearest + NEIGHBORS * limit) & (nearest <= limit + most)
    by = np.where(concerned, np.clip(below - limit, 0, most), 0).max(axis=0, initial=0)
    corners = lower_planes(planes, by, hull.points.mean(axis=0)) if by.any() else None
    smaller = hull if corners is None else hull_of(corners)
    return smaller if smaller.volume > 0 else hull


def finish(hull: Hull, touchable: Touchable, kept: Tolerances, wanted: Tolerances) -> Hull:
    """Turn a hull that meets `kept` into a part: lower faces, leave out corners within `wanted`."""
    return wanted.reduced(lower_faces(hull, touchable, kept), FINAL_LOSS)[0]


def finish_all(
    hulls: list[Hull],
    mesh: trimesh.Trimesh,
    touchable: Touchable,
    kept: Tolerances,
    wanted: Tolerances,
) -> tuple[list[Hull], Tolerances]:
    """Turn hulls into parts within bounds, loosened from `kept` if other points need it (ours)."""
    for number in count():
        finished = [finish(hull, touchable, kept, wanted) for hull in hulls]
        others = touchable_points(mesh, f"parts, check {number}")
        if share_within(others.points, finished, kept.deviation) <= CHECKED * MAX_BURIED:
            break
        if number < REFITS:
            touchable = touchable.and_more(others)
        else:
            kept = kept.loosened(STEP)
    return finished, kept

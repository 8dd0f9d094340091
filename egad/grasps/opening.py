"""The opening that a grasp needs for whole fingers (ours)."""

from collections.abc import Callable

import numpy as np

from egad._util.arrays import Flags, Floats, Ints
from egad._util.kernels import kernel
from egad.geometry import RayCaster
from egad.grasps.antipodal import ContactPairs
from egad.grasps.approach import touching_turns
from egad.grasps.collision import apart, clipped, local, spheres
from egad.grippers import (
    CLEARANCE,
    FINGERS,
    FIRST_FINGER,
    SECOND_FINGER,
    BoxBody,
    HandBody,
    JawBody,
    ModelBody,
    finger_span,
)


def needed_openings(
    caster: RayCaster, grasps: ContactPairs, approaches: Floats, body: HandBody
) -> Floats:
    """The smallest opening, metres, at which both whole fingers stand beside the object, (n,).

    Both are equally far from the middle of the contacts; the palm and the opening of the hand do
    not count. If it exceeds the width, closing pads meet something else before the contacts. Of a
    maker's model, tabulated openings are tried; infinite if the hand does not open that far.
    """
    return _NEEDED[type(body)](caster, grasps, approaches, body)


def _needed_by_boxes(
    caster: RayCaster, grasps: ContactPairs, approaches: Floats, body: BoxBody
) -> Floats:
    """The same for fingers that are boxes."""
    gripper = body.gripper
    triangles = caster.triangles
    around = spheres(triangles)
    frames = grasps.frames(approaches)
    base, tip = finger_span(gripper)
    side, thickness = gripper.finger_width / 2, gripper.finger_thickness
    column = np.array([[-np.inf, -side, base], [np.inf, side, tip]])
    middles = grasps.centers + (base + tip) / 2 * approaches
    half = grasps.widths / 2
    left = np.arange(len(grasps))
    while len(left):
        starts, ends = _gaps(
            triangles, *around, column, thickness, grasps.centers[left], frames[left], half[left]
        )
        aside = (starts + thickness / 2)[:, None] * grasps.axes[left]
        buried = caster.contains(middles[left] - aside) | caster.contains(middles[left] + aside)
        buried &= np.isfinite(ends)
        half[left] = np.where(buried, np.nextafter(ends, np.inf), starts)
        left = left[buried]
    return np.asarray(2 * half)


@kernel()
def _gaps(
    triangles: Floats,
    centers: Floats,
    radii: Floats,
    column: Floats,
    thickness: float,
    origins: Floats,
    frames: Floats,
    least: Floats,
) -> tuple[Floats, Floats]:
    """The first gap beyond `least` that both fingers fit into, (n,) from the middle each."""
    planes = np.zeros((4, 4))
    for axis in range(2):
        for end in range(2):
            sign = 2.0 * end - 1
            planes[2 * axis + end, axis + 1] = sign
            planes[2 * axis + end, 3] = -sign * column[end, axis + 1]
    starts, ends = np.empty(len(origins)), np.empty(len(origins))
    taken = np.empty((2 * len(triangles), 2))
    for n in range(len(origins)):
        count = _taken(
            triangles,
            centers,
            radii,
            column,
            planes,
            thickness,
            origins,
            frames,
            n,
            least[n],
            taken,
        )
        starts[n], ends[n] = _first_gap(taken[:count], least[n])
    return starts, ends


@kernel()
def _taken(
    triangles: Floats,
    centers: Floats,
    radii: Floats,
    column: Floats,
    planes: Floats,
    thickness: float,
    origins: Floats,
    frames: Floats,
    n: int,
    least: float,
    taken: Floats,
) -> int:
    """Store the distances at which triangles reach into a finger as intervals; returns how many."""
    corners = np.empty((3, 3))
    count = 0
    for m in range(len(triangles)):
        x, y, z = local(centers, m, origins, frames, n)
        if abs(x) + radii[m] <= least or apart(y, radii[m], column, 1):
            continue
        if apart(z, radii[m], column, 2):
            continue
        for i in range(3):
            x, y, z = local(triangles[m], i, origins, frames, n)
            corners[i, 0], corners[i, 1], corners[i, 2] = x, y, z
        low, high = _extent(corners, column, planes, least)
        for near, far in ((low, high), (-high, -low)):
            if far > least:
                taken[count, 0], taken[count, 1] = near - thickness, far
                count += 1
    return count


@kernel()
def _extent(corners: Floats, column: Floats, planes: Floats, least: float) -> tuple[float, float]:
    """The range of x that a triangle has within a column; 0 to 0 if it is not beyond `least`."""
    low, high = np.inf, -np.inf
    aside, start, end = 0.0, np.inf, -np.inf
    for i in range(3):
        x, y, z = corners[i]
        low, high = min(low, x), max(high, x)
        aside, start, end = max(aside, abs(y)), min(start, z), max(end, z)
    if max(-low, high) <= least or end < column[0, 2] or start > column[1, 2]:
        return 0.0, 0.0
    if aside <= column[1, 1] and start >= column[0, 2] and end <= column[1, 2]:
        return low, high
    rest, size = clipped(corners, planes)
    if size == 0:
        return 0.0, 0.0
    return rest[:size, 0].min(), rest[:size, 0].max()


@kernel()
def _first_gap(taken: Floats, least: float) -> tuple[float, float]:
    """Where the first gap between open intervals begins, at `least` or later, and where it ends."""
    free = least
    for i in np.argsort(taken[:, 0]):
        if taken[i, 0] >= free:
            return free, taken[i, 0]
        free = max(free, taken[i, 1])
    return free, np.inf


def _needed_by_fingers(
    caster: RayCaster, grasps: ContactPairs, approaches: Floats, body: ModelBody
) -> Floats:
    """The same for two fingers of a model: the pads of the hand will reach the contacts."""
    frames = grasps.frames(approaches)
    needed = np.full(len(grasps), np.inf)
    openings = body.model.openings
    for level in np.flatnonzero(openings <= body.gripper.opening + CLEARANCE):
        opening = float(openings[level])
        rows = np.flatnonzero(np.isinf(needed) & (grasps.widths <= opening - CLEARANCE))
        if not len(rows):
            continue
        parts = body.at(int(level), bodies=FINGERS)
        behind = body.reach(grasps.widths[rows]) - body.reach(np.array([opening]))
        where = grasps.centers[rows], frames[rows]
        blocked = touching_turns(caster, parts, *where, behind=behind)
        needed[rows[~blocked[:, 0]]] = opening
    return needed


def _needed_by_jaw(
    caster: RayCaster, grasps: ContactPairs, approaches: Floats, body: JawBody
) -> Floats:
    """The same for one moving jaw, which sweeps from wide open until something stops it."""
    widths, openings = grasps.widths, body.model.openings
    levels = np.flatnonzero(openings <= body.gripper.opening + CLEARANCE)
    everything = np.arange(len(grasps))
    stands = ~_blocked(caster, grasps, approaches, body, everything, int(levels[-1]), FIRST_FINGER)
    needed = np.full(len(grasps), np.inf)
    left = stands.copy()
    for level in levels[::-1]:
        rows = np.flatnonzero(left & (widths <= openings[level] - CLEARANCE))
        if not len(rows):
            break
        blocked = _blocked(caster, grasps, approaches, body, rows, int(level), SECOND_FINGER)
        needed[rows[~blocked]] = openings[level]
        left[rows[blocked]] = False
    return needed


_NEEDED: dict[type[HandBody], Callable[..., Floats]] = {
    BoxBody: _needed_by_boxes,
    ModelBody: _needed_by_fingers,
    JawBody: _needed_by_jaw,
}


def _blocked(
    caster: RayCaster,
    grasps: ContactPairs,
    approaches: Floats,
    body: JawBody,
    rows: Ints,
    level: int,
    side: int,
) -> Flags:
    """Whether one of the jaws touches the object at some of the grasps, (n,)."""
    chosen = grasps.take(rows)
    frames = chosen.frames(approaches[rows])
    clearance = {"clearance": 0.0} if side == SECOND_FINGER else {}
    aside = body.aside(chosen.widths, body.model.openings[[level]], **clearance)
    origins = chosen.centers + aside[:, None] * chosen.axes
    parts = body.at(level, bodies=(side,))
    return np.asarray(touching_turns(caster, parts, origins, frames)[:, 0])

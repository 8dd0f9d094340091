"""A hand with one jaw that is fixed to the palm, and one that turns or slides.

The closing axis is the normal of the fixed jaw's inner face. The pads are where both jaws are
closest to each other, which is at the tips for most hands. The opening is the gap between the inner
faces there, along the closing axis, at the middle of their breadth: where a body that lies against
the fixed jaw touches them. The fixed pad stays where it is, so the middle between the pads moves by
half the opening, and faces of a jaw that turns are parallel at one opening only.
"""

from typing import NamedTuple

import numpy as np
from scipy.spatial import Delaunay, QhullError

from egad._util.arrays import Floats
from egad.errors import UserError
from egad.grippers.jaw_solids import FACING, JawFrame, JawPads, JawSolids
from egad.grippers.mechanism import body_name
from egad.grippers.pads import LEVELS, UNEVEN, check_opening

GRID = 5e-4  # metres, between points of a jaw's face
MARGIN = 5  # grid points around those that were found on it
LINE, LINES = 401, 11  # points on a line over the pads, and how many lines
AHEAD = 2e-3  # metres between the foremost known point of the fixed jaw's face and that grid
TOUCH = 1e-4  # metres by which jaws may overlap when they are closed
PAD_DEPTH = 1e-3  # metres that a pad may lie behind the foremost point of its jaw
FLAT, BUMPS = 1e-4, 0.1  # metres by which points of a plane differ, and fraction of bumps on it
CLOSED = 2e-3  # metres that a pad may be further from the other jaw than its foremost point
FINE = 8 * LEVELS  # positions of the joint at which the gap is measured first
HALVINGS = 12  # of the step in which jaws meet


class JawStroke(NamedTuple):
    """The way of a jaw from closed to open."""

    positions: Floats  # (k, q) positions of all joints
    openings: Floats  # (k,) gap of the inner faces at the pads, ascending, metres
    angles: Floats  # (k,) radians between them; positive if they are farther apart at the tips
    pads: JawPads  # where they are measured


def find_jaw_stroke(jaws: JawSolids, frame: JawFrame, tcp: Floats | None = None) -> JawStroke:
    """Where the pads (middle: `tcp`) are, and how far apart at each position; or `UserError`."""
    low, high = jaws.mechanism.ranges()[0]
    closed, wide = (low, high) if jaws.facing.closing < 0 else (high, low)
    joints = np.linspace(closed, wide, FINE)
    angles = np.array([jaws.angle(joint, frame) for joint in joints])
    parallel = int(np.abs(angles).argmin())
    way = np.argsort(angles)
    pads = _find_pads(jaws, frame, joints, float(np.interp(0.0, angles[way], joints[way])))
    if tcp is not None:
        pads = pads._replace(middle=_on_fixed_face(jaws, frame, tcp, pads.middle))
    gaps = np.array([jaws.gap(pads, float(joint), frame) for joint in joints])
    first, last = _useful(gaps, parallel)
    names = f"{body_name(jaws.mechanism.model, jaws.body)} and the fixed jaw"
    check_opening(float(gaps[last]), names, moves=last > first)
    levels = np.linspace(joints[first], joints[last], LEVELS)
    openings = np.array([jaws.gap(pads, float(joint), frame) for joint in levels])
    return JawStroke(
        np.array([jaws.positions(float(joint)) for joint in levels]),
        np.maximum.accumulate(openings),
        np.array([jaws.angle(float(joint), frame) for joint in levels]),
        pads,
    )


def _useful(gaps: Floats, start: int) -> tuple[int, int]:
    """Range of positions around one where the gap is known and grows, except for small steps."""
    gaps = np.where(gaps >= -TOUCH, gaps, np.nan)
    known = np.isfinite(gaps)
    if not known.any():
        raise UserError("its jaws never face each other where they are nearest")
    start = int(np.flatnonzero(known)[np.abs(np.flatnonzero(known) - start).argmin()])
    first = last = start
    while first > 0 and gaps[first - 1] < gaps[first] + PAD_DEPTH:
        first -= 1
    while last + 1 < len(gaps) and gaps[last + 1] > gaps[last] - PAD_DEPTH:
        last += 1
    return first, last


def _find_pads(jaws: JawSolids, frame: JawFrame, joints: Floats, parallel: float) -> JawPads:
    """Where the jaws meet first when they close, and what protrudes as far, once parallel."""
    points, gaps = _opposite(jaws, frame, parallel, _grid(jaws, frame))
    if not len(points):
        raise UserError("its jaws never face each other where their faces are parallel")
    cells = points + GRID / 2 * frame.approach  # their ends that are nearest to the tips
    facing = cells + gaps[:, None] * frame.closing
    velocities, _ = jaws.mechanism.velocities(jaws.positions(parallel), jaws.body, facing)
    along = np.abs(velocities @ frame.closing)
    moved = along > FACING * np.linalg.norm(velocities, axis=1)  # mostly along the closing axis
    if moved.any():
        points, gaps = points[moved], gaps[moved]
    apart = _gaps_before_contact(jaws, frame, joints, points)
    first = int(apart.argmin())
    heights = points @ frame.closing
    ends = heights + gaps
    beside = np.abs((points - points[first]) @ frame.approach) < GRID
    level, end = heights[beside].max(), ends[beside].min()
    both = (np.abs(heights - level) < PAD_DEPTH) & (np.abs(ends - end) < PAD_DEPTH)
    passed = np.isinf(apart) & ((points - points[first]) @ frame.approach > 0)
    both &= (apart <= apart[first] + CLOSED) | passed
    both[first] = True
    chosen = points[both] @ frame.matrix
    middle, extent = _middle(chosen[:, 1:]), np.ptp(chosen[:, 1:], axis=0) + GRID
    lines = _lines(chosen[:, 0].max() + AHEAD, middle, extent) @ frame.matrix.T
    points, gaps = _opposite(jaws, frame, parallel, lines)
    heights = points @ frame.closing
    placement = jaws.mechanism.placement(jaws.positions(parallel))
    turn, place = placement.turns[jaws.body], placement.places[jaws.body]
    face, opposite = -_foremost(-heights), _foremost(heights + gaps)
    bridge = np.array([opposite, *middle]) - place @ frame.matrix
    pad, further = frame.matrix @ np.array([face, *middle]), gaps - (opposite - face)
    recess = (float((further > 2 * UNEVEN).mean()), float(further.max()))
    return JawPads(pad, extent, bridge, frame.matrix.T @ turn, recess)


def _foremost(depths: Floats) -> float:
    """The depth of the first of some points, or of the plane of most with few bumps before it."""
    near = depths[depths <= depths.min() + PAD_DEPTH]
    middle = float(np.median(near))
    flat = (np.abs(near - middle) < FLAT).mean() > 0.5 and (near < middle - FLAT).mean() < BUMPS
    return middle if flat else float(near.min())


def _opposite(
    jaws: JawSolids, frame: JawFrame, joint: float, points: Floats
) -> tuple[Floats, Floats]:
    """Points (k, 3) of the fixed face behind those with a moving one before them, and gaps."""
    behind = jaws.fixed_face(points, frame)
    here = np.isfinite(behind)
    points = points[here] - behind[here, None] * frame.closing
    gaps = jaws.gaps(points, joint, frame)
    return points[np.isfinite(gaps)], gaps[np.isfinite(gaps)]


def _lines(height: float, middle: Floats, extent: Floats) -> Floats:
    """Points on lines along and across the pads, (n, 3): close enough to meet their sharp edges."""
    close, few = np.linspace(-0.5, 0.5, LINE), np.linspace(-0.4, 0.4, LINES)
    y, z = (
        np.concatenate([a.ravel(), b.ravel()])
        for a, b in zip(np.meshgrid(close, few), np.meshgrid(few, close), strict=True)
    )
    return np.stack(
        [np.full_like(y, height), middle[0] + y * extent[0], middle[1] + z * extent[1]], axis=1
    )


def _gaps_before_contact(
    jaws: JawSolids, frame: JawFrame, joints: Floats, points: Floats
) -> Floats:
    """Distances from points of the fixed face to the other jaw, just before it touches any.

    Infinite where the other jaw has swung past by then, or has only a steep face there.
    """
    nearest = np.full(len(points), np.inf)

    def clear(joint: float) -> bool:
        """Whether the jaw touches no point at a position; remembers how near it is."""
        nonlocal nearest
        gaps = jaws.gaps(points, joint, frame)
        if np.isneginf(gaps).any():
            return False
        nearest = gaps if np.isfinite(gaps).any() else nearest
        return True

    free = blocked = float(joints[-1])
    for blocked in map(float, joints[::-8]):
        if not clear(blocked):
            break
        free = blocked
    for _ in range(HALVINGS):
        middle = (free + blocked) / 2
        free, blocked = (middle, blocked) if clear(middle) else (free, middle)
    return nearest


def _middle(outline: Floats) -> Floats:
    """Middle of the area that points on a grid span, (2,): holes in it do not shift it."""
    try:
        triangles = outline[Delaunay(outline).simplices]
    except QhullError:  # they are on a line
        return np.asarray(outline.mean(axis=0))
    areas = np.abs(np.linalg.det(triangles[:, 1:] - triangles[:, :1]))
    return np.asarray(np.average(triangles.mean(axis=1), axis=0, weights=areas))


def _on_fixed_face(jaws: JawSolids, frame: JawFrame, tcp: Floats, pad: Floats) -> Floats:
    """The point of the fixed jaw's face at the depth and breadth of another point."""
    off = frame.matrix.T @ (tcp - pad)
    start = tcp - off[0] * frame.closing + GRID * frame.closing
    (behind,) = jaws.fixed_face(start[None], frame)
    if not np.isfinite(behind):
        raise UserError("there is no face of the fixed jaw at its tcp")
    return np.asarray(start - behind * frame.closing)


def _grid(jaws: JawSolids, frame: JawFrame) -> Floats:
    """Points just in front of the foremost point of the fixed jaw's face, all over it, (n, 3)."""
    seen = jaws.facing.points @ frame.matrix
    low, high = seen.min(axis=0), seen.max(axis=0)
    across, along = (
        GRID * (np.arange(*np.round([low[axis] / GRID - MARGIN, high[axis] / GRID + MARGIN])) + 0.5)
        for axis in (1, 2)
    )
    y, z = np.meshgrid(across, along, indexing="ij")
    points = np.stack([np.full_like(y, high[0] + AHEAD), y, z], axis=2)
    return np.asarray(points.reshape(-1, 3) @ frame.matrix.T)

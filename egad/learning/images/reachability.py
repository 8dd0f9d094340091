"""Whether a hand can reach grasps from above (ours).

The approach is turned about the closing axis until it is as near to the vertical as possible, as in
Dex-Net (Mahler et al. 2017).
"""

import numpy as np

from egad._util.arrays import Flags, Floats
from egad.geometry import RayCaster
from egad.grasps import (
    FIXED_SIDE_CLEARANCE,
    MIN_DEPTH,
    TABLE_CLEARANCE,
    first_approaches,
    roomy,
    touching_turns,
)
from egad.grippers import HandBody, finger_span

GAP = 1e-5  # metres; something is in the way if it is nearer than the contact by more than this


def is_reachable(
    scene: RayCaster, centers: Floats, axes: Floats, widths: Floats, body: HandBody, *, way: float
) -> Flags:
    """Which of n grasps can be reached from above without touching anything else, (n,).

    The open hand stays 3 mm above the table and reaches at least 3 mm beyond the contacts; a fixed
    jaw is 3 mm before its contact. It must be free there and on its way in, `way` metres long.
    """
    approaches = first_approaches(axes)
    frames = np.stack([axes, np.cross(approaches, axes), approaches], axis=1)
    openings = roomy(widths, body.gripper)
    behind = body.reach(widths) - body.reach(openings)
    aside = body.aside(widths, openings, FIXED_SIDE_CLEARANCE)
    aside = np.where(openings < body.gripper.opening, aside, 0.0)
    there = centers - behind[:, None] * approaches + aside[:, None] * axes
    lowest = _lowest(body, there, frames, openings)
    lift = np.maximum(TABLE_CLEARANCE - lowest, 0) / -approaches[:, 2]
    penetration = finger_span(body.gripper)[1] - lift
    origins = there - lift[:, None] * approaches
    reached = (penetration >= MIN_DEPTH) & _closes(scene, centers, axes, widths, openings, aside)
    rows = np.flatnonzero(reached)
    reached[rows] = ~_touching(scene, body, origins[rows], frames[rows], openings[rows], way)
    return reached


def _closes(
    scene: RayCaster, centers: Floats, axes: Floats, widths: Floats, openings: Floats, aside: Floats
) -> Flags:
    """Whether the middles of both pads meet nothing before the contacts, (n,)."""
    free = np.ones(len(centers), dtype=bool)
    for side in (-1, 1):
        starts = centers + side * (openings / 2 + side * aside)[:, None] * axes
        travel = (openings - widths) / 2 + side * aside
        free &= scene.first_hits(starts, -side * axes).distances > travel - GAP
    return free


def _lowest(body: HandBody, origins: Floats, frames: Floats, openings: Floats) -> Floats:
    """The height of the lowest corner of a hand's boxes, (n,)."""
    lowest = np.full(len(origins), np.inf)
    for rows, parts, shifts in body.pieces(openings):
        slopes = frames[rows][:, :, 2]
        placed = origins[rows, 2] + np.sum(shifts * slopes, axis=1)
        for part in parts:
            # the lower face of a box along each of its axes
            corner = np.minimum(slopes * part.box[0], slopes * part.box[1]).sum(axis=1)
            lowest[rows] = np.minimum(lowest[rows], placed + corner)
    return lowest


def _touching(
    scene: RayCaster, body: HandBody, origins: Floats, frames: Floats, openings: Floats, way: float
) -> Flags:
    """Whether a hand touches something at its place or on its way there, (n,)."""
    result = np.zeros((len(origins), 1), dtype=bool)
    for rows, parts, shifts in body.pieces(openings, way):
        if not len(rows):
            continue
        moved = origins[rows] + np.einsum("ni,nij->nj", shifts, frames[rows])
        result[rows] = touching_turns(scene, parts, moved, frames[rows], known=result[rows])
    return result[:, 0]

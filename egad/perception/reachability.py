"""Which labelled grasps a hand can reach from above where an object lies (ours).

The approach is turned about the closing axis until it is as near to the vertical as can be, as in
Dex-Net (Mahler et al. 2017).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from egad.geometry import RayCaster
from egad.grasps import (
    LEAST_BITE,
    TABLE_CLEARANCE,
    blocked_turns,
    first_approaches,
    roomy,
    swallowed,
)
from egad.grippers import Body, finger_span

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Ints = NDArray[np.int64]
STRAIGHT = np.zeros(1)


class GraspCandidates(NamedTuple):
    """Grasps of an object, in the frame of its mesh, metres.

    Attributes:
        numbers: (n,) numbers of the labels.
        centers: (n, 3) midpoints of the contacts.
        axes: (n, 3) unit vectors from the first contact to the second.
        widths: (n,) distances of the contacts.
        qualities: (n,).
    """

    indices: Ints
    centers: Floats
    axes: Floats
    widths: Floats
    qualities: Floats

    def chosen(self, which: Flags) -> "GraspCandidates":
        """Some of them."""
        return GraspCandidates(*(values[which] for values in self))  # type: ignore[arg-type]


def reachable(
    caster: RayCaster,
    grasps: GraspCandidates,
    resting: Floats,
    body: Body,
    *,
    tilt: float,
    way: float,
) -> tuple[GraspCandidates, Flags]:
    """The grasps that can be approached from above, and which of them are free.

    The hand opens 8 mm wider than the contacts on either side, or as wide as it can. Its pads are
    centered on the contacts, or as low as they get: it stays 3 mm above the table, and reaches at
    least 3 mm beyond the contacts. A grasp is free if the hand can do that without touching the
    object there or on its way in.

    Args:
        caster: Of the object, closed, metres.
        grasps: All its grasps.
        resting: (4, 4) from the frame of the mesh to that of the table, whose z is up.
        body: The hand.
        tilt: Largest angle between approach and vertical, radians.
        way: Length of the straight way in, metres.

    Returns:
        The k reachable grasps, and (k,) whether each is free.
    """
    rotation, height = resting[:3, :3], resting[2, 3]
    approaches = first_approaches(grasps.axes @ rotation.T) @ rotation
    near = approaches @ -rotation[2] >= np.cos(tilt)
    chosen, approaches = grasps.chosen(near), approaches[near]
    frames = np.stack([chosen.axes, np.cross(approaches, chosen.axes), approaches], axis=1)
    openings = roomy(chosen.widths, body.gripper)
    behind = body.reach(chosen.widths) - body.reach(openings)
    there = chosen.centers - behind[:, None] * approaches
    lowest = _lowest(body, there, frames, openings, rotation[2]) + height
    lift = np.maximum(TABLE_CLEARANCE - lowest, 0) / (approaches @ -rotation[2])
    bite = finger_span(body.gripper)[1] - lift
    origins = there - lift[:, None] * approaches
    return chosen, (bite >= LEAST_BITE) & ~_touching(caster, body, origins, frames, openings, way)


def _lowest(body: Body, origins: Floats, frames: Floats, openings: Floats, up: Floats) -> Floats:
    """The height of the lowest corner of a hand's boxes over the origin of the mesh, (n,)."""
    lowest = np.full(len(origins), np.inf)
    for rows, parts, shifts in body.pieces(openings):
        slopes = frames[rows] @ up
        placed = origins[rows] @ up + np.sum(shifts * slopes, axis=1)
        for part in parts:
            # of a box, along each of its axes the lower face
            corner = np.minimum(slopes * part.box[0], slopes * part.box[1]).sum(axis=1)
            lowest[rows] = np.minimum(lowest[rows], placed + corner)
    return lowest


def _touching(
    caster: RayCaster, body: Body, origins: Floats, frames: Floats, openings: Floats, way: float
) -> Flags:
    """Whether a hand touches the object at its place or on its way there, (n,)."""
    result = np.zeros((len(origins), 1), dtype=bool)
    for rows, parts, shifts in body.pieces(openings, way):
        if not len(rows):
            continue
        moved = origins[rows] + np.einsum("ni,nij->nj", shifts, frames[rows])
        known = result[rows] | swallowed(caster, parts, moved, frames[rows], STRAIGHT)
        result[rows] = blocked_turns(
            caster.triangles, parts, moved, frames[rows], STRAIGHT, known=known
        )
    return result[:, 0]

"""Which labelled grasps a hand can reach from above where an object lies (ours).

The approach is turned about the closing axis until it is as near to the vertical as can be, as in
Dex-Net (Mahler et al. 2017).
"""

from typing import NamedTuple

import numpy as np
import trimesh
from numpy.typing import NDArray

from egad.geometry import RayCaster
from egad.grasps import (
    LEAST_BITE,
    TABLE_CLEARANCE,
    Gripper,
    Part,
    blocked_turns,
    finger_span,
    first_approaches,
    parts,
    roomy,
    swallowed,
)

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


class Hand(NamedTuple):
    """What comes to the object.

    Attributes:
        gripper: Sizes.
        palm: A mesh in the place of its palm box, see `egad.grasps.hand.parts`.
        way: Length of its straight way in, metres.
    """

    gripper: Gripper
    palm: trimesh.Trimesh | None
    way: float


def reachable(
    caster: RayCaster, grasps: GraspCandidates, resting: Floats, hand: Hand, tilt: float
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
        hand: The hand.
        tilt: Largest angle between approach and vertical, radians.

    Returns:
        The k reachable grasps, and (k,) whether each is free.
    """
    rotation, height = resting[:3, :3], resting[2, 3]
    approaches = first_approaches(grasps.axes @ rotation.T) @ rotation
    near = approaches @ -rotation[2] >= np.cos(tilt)
    chosen, approaches = grasps.chosen(near), approaches[near]
    frames = np.stack([chosen.axes, np.cross(approaches, chosen.axes), approaches], axis=1)
    openings = roomy(chosen.widths, hand.gripper)
    lowest = _lowest(hand, chosen.centers, frames, openings, rotation[2]) + height
    lift = np.maximum(TABLE_CLEARANCE - lowest, 0) / (approaches @ -rotation[2])
    bite = finger_span(hand.gripper)[1] - lift
    origins = chosen.centers - lift[:, None] * approaches
    return chosen, (bite >= LEAST_BITE) & ~_touching(caster, hand, origins, frames, openings)


def _bodies(hand: Hand, openings: Floats, way: float = 0.0) -> list[tuple[list[Part], Floats]]:
    """Both fingers and the palm, and how far each is shifted along the axis, (n,).

    Fingers that are open less than the gripper can are those of the open hand, shifted.
    """
    first, second, *palm = parts(hand.gripper, hand.palm, way)
    closed = (hand.gripper.opening - openings) / 2
    return [([first], closed), ([second], -closed), (palm, np.zeros_like(closed))]


def _lowest(hand: Hand, origins: Floats, frames: Floats, openings: Floats, up: Floats) -> Floats:
    """The height of the lowest corner of a hand's boxes over the origin of the mesh, (n,)."""
    found = []
    for body, shifts in _bodies(hand, openings):
        placed = origins @ up + shifts * (frames[:, 0] @ up)
        for part in body:
            # of a box, along each of its axes the lower face
            slopes = frames @ up
            corner = np.minimum(slopes * part.box[0], slopes * part.box[1]).sum(axis=1)
            found.append(placed + corner)
    return np.asarray(np.min(found, axis=0))


def _touching(
    caster: RayCaster, hand: Hand, origins: Floats, frames: Floats, openings: Floats
) -> Flags:
    """Whether a hand touches the object at its place or on its way there, (n,)."""
    triangles = caster.triangles
    result = np.zeros((len(origins), 1), dtype=bool)
    if len(result) == 0:
        return result[:, 0]
    for body, shifts in _bodies(hand, openings, hand.way):
        moved = origins + shifts[:, None] * frames[:, 0]
        result |= swallowed(caster, body, moved, frames, STRAIGHT)
        result = blocked_turns(triangles, body, moved, frames, STRAIGHT, known=result)
    return result[:, 0]

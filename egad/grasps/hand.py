"""The body of a parallel-jaw hand: two finger boxes, and a palm that is a box or convex pieces.

The frame of the hand has its origin midway between the contacts. x is the closing axis, from the
first contact to the second; z is the approach, along which the hand moves towards the object;
y = z cross x. The contacts are in the middle of square pads at the ends of the fingers, so the
fingertips reach half a finger's width beyond the origin. The palm begins where the fingers end.
"""

from typing import NamedTuple

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from egad.errors import RejectedError
from egad.grasps.parameters import Gripper

Floats = NDArray[np.float64]
CLEARANCE = 1e-4  # metres between a contact as wide as the opening and the finger


class Part(NamedTuple):
    """A convex part of a hand.

    Attributes:
        box: (2, 3) low and high corner of its bounding box, metres.
        planes: (k, 4) outward unit normals and offsets: the part is where normal . point + offset
            is nowhere positive. Without any it fills its box.
        middle: (3,) a point in it, metres.
    """

    box: Floats
    planes: Floats
    middle: Floats


def finger_span(gripper: Gripper) -> tuple[float, float]:
    """Where the fingers begin and end along the approach, metres from the contacts."""
    tip = min(gripper.finger_width, gripper.finger_length) / 2
    return tip - gripper.finger_length, tip


def parts(
    gripper: Gripper, palm: trimesh.Trimesh | None = None, retreat: float = 0.0
) -> list[Part]:
    """The open hand, swept back by `retreat`: first finger (at negative x), second finger, palm.

    Args:
        gripper: Sizes of the boxes.
        palm: A mesh in the place of the palm box. Its origin is the middle of the palm's face,
            where the fingers begin, its axes are those of the hand, its unit is the metre. Each of
            its bodies counts with its convex hull.
        retreat: Length of the straight way that the hand came, metres.

    Raises:
        RejectedError: A body of the mesh is flat.
    """
    inner = gripper.opening / 2 + CLEARANCE
    outer = inner + gripper.finger_thickness
    base, tip = finger_span(gripper)
    side = gripper.finger_width / 2
    half = np.array(gripper.palm) / 2
    fingers = [
        _box([-outer, -side, base - retreat], [-inner, side, tip]),
        _box([inner, -side, base - retreat], [outer, side, tip]),
    ]
    if palm is None:
        back = base - gripper.palm[2] - retreat
        return [*fingers, _box([-half[0], -half[1], back], [half[0], half[1], base])]
    pieces = palm.split(only_watertight=False)
    shift = np.array([0, 0, base])
    return [*fingers, *(_hull(np.asarray(each.vertices) + shift, retreat) for each in pieces)]


def _box(low: list[float], high: list[float]) -> Part:
    box = np.array([low, high])
    return Part(box, np.empty((0, 4)), box.mean(axis=0))


def _hull(points: Floats, retreat: float) -> Part:
    """The convex hull of points, swept along -z."""
    swept = np.vstack([points, points - [0, 0, retreat]])
    try:
        corners = points[ConvexHull(points).vertices]
        planes = np.unique(np.round(ConvexHull(swept).equations, 12), axis=0)
    except QhullError as error:
        raise RejectedError("one of its bodies is flat") from error
    return Part(np.stack([swept.min(axis=0), swept.max(axis=0)]), planes, corners.mean(axis=0))

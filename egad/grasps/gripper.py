"""Does the body of a parallel-jaw hand fit around the object?

The frame of the hand has its origin midway between the contacts. x is the closing axis, from the
first contact to the second; z is the approach, along which the hand moves towards the object;
y = z cross x. The contacts are in the middle of square pads at the ends of the fingers, so the
fingertips reach half a finger's width beyond the origin. The palm is a box behind the fingers.

The fingers are open as far as they go: a hand comes in like that, and it is what the sampler and
the robust quality close from.
"""

import numpy as np
import trimesh
from numpy.typing import NDArray

from egad.grasps.overlap import blocked_turns
from egad.grasps.sampler import Grasps
from egad.settings import Gripper

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
CLEARANCE = 1e-4  # metres between a contact as wide as the opening and the finger


def collision_free(
    mesh: trimesh.Trimesh,
    grasps: Grasps,
    gripper: Gripper,
    *,
    angles: int = 16,
    retreat: float = 0.1,
) -> tuple[Floats, Flags]:
    """Find for each of n grasps an approach along which the hand does not touch the object.

    The approaches tried are spread evenly around the closing axis, the first pointing down
    (along -z) as far as the axis allows. Of those that are free, at the grasp and on the way in,
    the one farthest from any that is not is taken.

    Args:
        mesh: The object, metres. Only its surface is tested.
        grasps: The grasps.
        gripper: The hand.
        angles: Approaches to try.
        retreat: Length of the straight way in, metres.

    Returns:
        (n, 3) unit approach vectors, and (n,) whether they are free; where none is, the vector
        is the first that was tried.
    """
    first = first_approaches(grasps.axes)
    turns = 2 * np.pi * np.arange(angles) / angles
    across = np.cross(first, grasps.axes)
    blocked = blocked_turns(
        np.asarray(mesh.triangles),
        boxes(gripper, retreat),
        grasps.centers,
        np.stack([grasps.axes, across, first], axis=1),
        turns,
    )
    turn = turns[_roomiest(blocked)][:, None]
    approach = np.cos(turn) * first - np.sin(turn) * across
    return approach, np.asarray(~blocked.all(axis=1))


def boxes(gripper: Gripper, retreat: float = 0.0) -> Floats:
    """The hand, swept back by `retreat`: low and high corners of its boxes, (3, 2, 3), metres.

    The boxes are the first finger (at negative x), the second finger and the palm.
    """
    inner = gripper.opening / 2 + CLEARANCE
    outer = inner + gripper.finger_thickness
    tip = fingertip(gripper)
    base = tip - gripper.finger_length
    side = gripper.finger_width / 2
    half = np.array(gripper.palm) / 2
    return np.array(
        [
            [[-outer, -side, base - retreat], [-inner, side, tip]],
            [[inner, -side, base - retreat], [outer, side, tip]],
            [[-half[0], -half[1], base - gripper.palm[2] - retreat], [half[0], half[1], base]],
        ]
    )


def fingertip(gripper: Gripper) -> float:
    """How far the fingers reach beyond the contacts, metres."""
    return min(gripper.finger_width, gripper.finger_length) / 2


def first_approaches(axes: Floats) -> Floats:
    """Unit vectors at right angles to closing axes, as near to -z as can be: (n, 3)."""
    down = np.array([0.0, 0.0, -1.0])
    vertical = np.abs(axes[:, 2:]) > 1 - 1e-9
    wanted = np.where(vertical, [-1.0, 0.0, 0.0], down)
    across = wanted - np.sum(wanted * axes, axis=1, keepdims=True) * axes
    return np.asarray(across / np.linalg.norm(across, axis=1, keepdims=True))


def _roomiest(blocked: Flags) -> NDArray[np.intp]:
    """Per row the first of the free angles that are farthest from any blocked one; else 0."""
    angles = blocked.shape[1]
    room = np.zeros(blocked.shape, dtype=int)
    near = blocked.copy()
    for step in range(1, angles // 2 + 2):
        room += ~near
        near = near | np.roll(blocked, step, axis=1) | np.roll(blocked, -step, axis=1)
    return np.asarray(room.argmax(axis=1))

"""From where the body of a hand reaches a grasp without touching the object (ours).

The fingers are open as far as they go: a hand comes in like that, and it is what the sampler and
the robust quality close from. `egad.grasps.hand` says what the hand looks like.
"""

from typing import NamedTuple

import numpy as np
import trimesh
from numpy.typing import NDArray

from egad.geometry import RayCaster
from egad.grasps.collision import blocked_turns
from egad.grasps.hand import Part, parts
from egad.grasps.parameters import Gripper
from egad.grasps.sampler import ContactPairs

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Indices = NDArray[np.int64]


class Approaches(NamedTuple):
    """The best approach to each of n grasps.

    Attributes:
        directions: (n, 3) unit vectors along which the hand moves towards the object.
        fits: (n,) whether the hand touches nothing when it is there.
        free: (n,) whether it touches nothing on the way in either.
        angles_fit: (n,) angles that fit.
        angles_collision_free: (n,) angles that are free.
    """

    directions: Floats
    fits: Flags
    free: Flags
    angles_fit: Indices
    angles_collision_free: Indices


def best_approaches(
    caster: RayCaster,
    grasps: ContactPairs,
    gripper: Gripper,
    palm: trimesh.Trimesh | None = None,
    *,
    angles: int = 16,
    way: float = 0.1,
) -> Approaches:
    """Find for each of n grasps the approach along which the open hand has most room.

    The approaches tried are spread evenly around the closing axis, the first pointing down
    (along -z) as far as the axis allows. At each, the hand is tested at the grasp and along its
    straight way in, exactly: it is swept along that way, and no part of it may share a point with
    the object, surface or inside. Of the approaches that are free, the one farthest from any that
    is not is taken; else of those that fit at the grasp; else the first.

    Args:
        caster: Of the object, closed, metres.
        grasps: The grasps.
        gripper: The hand.
        palm: A mesh in the place of its palm box, see `egad.grasps.hand.parts`.
        angles: Approaches to try.
        way: Length of the straight way in, metres.
    """
    triangles = caster.triangles
    first = first_approaches(grasps.axes)
    frames = np.stack([grasps.axes, np.cross(first, grasps.axes), first], axis=1)
    turns = 2 * np.pi * np.arange(angles) / angles
    hand = parts(gripper, palm)
    there = blocked_turns(triangles, hand, grasps.centers, frames, turns)
    there |= swallowed(caster, hand, grasps.centers, frames, turns)
    swept = parts(gripper, palm, way)
    coming = blocked_turns(triangles, swept, grasps.centers, frames, turns, known=there)
    fits, free = ~there.all(axis=1), ~coming.all(axis=1)
    best = np.where(free, _roomiest(coming), _roomiest(there))
    turn = turns[best][:, None]
    directions = np.cos(turn) * frames[:, 2] - np.sin(turn) * frames[:, 1]
    counts = [np.sum(~blocked, axis=1) for blocked in (there, coming)]
    return Approaches(directions, np.asarray(fits), np.asarray(free), *counts)


def first_approaches(axes: Floats) -> Floats:
    """Unit vectors at right angles to closing axes, as near to -z as can be: (n, 3)."""
    down = np.array([0.0, 0.0, -1.0])
    vertical = np.abs(axes[:, 2:]) > 1 - 1e-9
    wanted = np.where(vertical, [-1.0, 0.0, 0.0], down)
    across = wanted - np.sum(wanted * axes, axis=1, keepdims=True) * axes
    return np.asarray(across / np.linalg.norm(across, axis=1, keepdims=True))


def swallowed(
    caster: RayCaster, hand: list[Part], origins: Floats, frames: Floats, turns: Floats
) -> Flags:
    """In which poses a part of the hand has its middle in the object: (n, k).

    A part that touches no surface lies all inside or all outside, as any point of it.
    """
    result = np.zeros((len(origins), len(turns)), dtype=bool)
    for x, y, z in (part.middle for part in hand):
        across = np.cos(turns) * y - np.sin(turns) * z
        along = np.sin(turns) * y + np.cos(turns) * z
        turned = np.stack([np.full_like(turns, x), across, along], axis=1)
        points = (origins[:, None] + turned @ frames).reshape(-1, 3)
        result |= caster.contains(points).reshape(result.shape)
    return result


def _roomiest(blocked: Flags) -> Indices:
    """Per row the first of the free angles that are farthest from any blocked one; else 0."""
    angles = blocked.shape[1]
    room = np.zeros(blocked.shape, dtype=int)
    near = blocked.copy()
    for step in range(1, angles // 2 + 2):
        room += ~near
        near = near | np.roll(blocked, step, axis=1) | np.roll(blocked, -step, axis=1)
    return np.asarray(room.argmax(axis=1))

"""Approaches from which the body of a hand reaches a grasp without touching the object (ours).

The fingers are fully open: a hand approaches like that, and the sampler and the robust quality
close the fingers from there. `egad.grippers.hand` describes the hand.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from egad._util.arrays import Flags, Floats, Ints
from egad.geometry import RayCaster
from egad.grasps.antipodal import ContactPairs
from egad.grasps.collision import blocked_turns
from egad.grippers import HandBody, Part

STRAIGHT = np.zeros(1)  # radians; not turned


class Approaches(NamedTuple):
    """The best approach to each of n grasps."""

    directions: Floats  # (n, 3) unit vectors along which the hand moves towards the object
    fits: Flags  # (n,) whether the hand touches nothing at the grasp
    free: Flags  # (n,) whether it touches nothing on the way in either
    angles_fit: Ints  # (n,) number of angles that fit
    angles_collision_free: Ints  # (n,) number of angles that are free


def best_approaches(
    caster: RayCaster, grasps: ContactPairs, body: HandBody, *, angles: int = 16, way: float = 0.1
) -> Approaches:
    """Find the approach with the most clearance for the open hand, for each of n grasps.

    Approaches are even around the closing axis, from -z as far as it allows, and tested exactly, at
    the grasp and swept over `way`, metres. The free one farthest from others is best, or of those
    that fit, or the first.
    """
    first = first_approaches(grasps.axes)
    frames = grasps.frames(first)
    turns = 2 * np.pi * np.arange(angles) / angles
    hand, swept = body.parts(), body.parts(way)
    opening = np.array([body.gripper.opening])
    behind = body.reach(grasps.widths) - body.reach(opening)
    origins = grasps.centers + body.aside(grasps.widths, opening)[:, None] * grasps.axes
    there = touching_turns(caster, hand, origins, frames, turns, behind=behind)
    coming = blocked_turns(
        caster.triangles, swept, origins, frames, turns, known=there, behind=behind
    )
    fits, free = ~there.all(axis=1), ~coming.all(axis=1)
    best = np.where(free, _roomiest(coming), _roomiest(there))
    turn = turns[best][:, None]
    directions = np.cos(turn) * frames[:, 2] - np.sin(turn) * frames[:, 1]
    counts = [np.sum(~blocked, axis=1) for blocked in (there, coming)]
    return Approaches(directions, np.asarray(fits), np.asarray(free), *counts)


def first_approaches(axes: Floats) -> Floats:
    """Unit vectors perpendicular to closing axes, as close to -z as possible: (n, 3)."""
    down = np.array([0.0, 0.0, -1.0])
    vertical = np.abs(axes[:, 2:]) > 1 - 1e-9
    wanted = np.where(vertical, [-1.0, 0.0, 0.0], down)
    across = wanted - np.sum(wanted * axes, axis=1, keepdims=True) * axes
    return np.asarray(across / np.linalg.norm(across, axis=1, keepdims=True))


def touching_turns(
    caster: RayCaster,
    parts: Sequence[Part],
    origins: Floats,
    frames: Floats,
    turns: Floats = STRAIGHT,
    *,
    known: Flags | None = None,
    behind: Floats | None = None,
) -> Flags:
    """In which poses a part and the object share a point, (n, k): arguments of `blocked_turns`."""
    inside = _swallowed(caster, parts, origins, frames, turns, behind)
    known = inside if known is None else inside | known
    return blocked_turns(
        caster.triangles, parts, origins, frames, turns, known=known, behind=behind
    )


def _swallowed(
    caster: RayCaster,
    hand: Sequence[Part],
    origins: Floats,
    frames: Floats,
    turns: Floats,
    behind: Floats | None,
) -> Flags:
    """In which poses a part has its middle in the object, (n, k): one that touches no surface."""
    result = np.zeros((len(origins), len(turns)), dtype=bool)
    back = np.zeros((len(origins), 1)) if behind is None else behind[:, None]
    for x, y, z in (part.middle for part in hand):
        across = np.cos(turns) * y - np.sin(turns) * (z - back)
        along = np.sin(turns) * y + np.cos(turns) * (z - back)
        turned = np.stack([np.full_like(across, x), across, along], axis=2)
        points = (origins[:, None] + turned @ frames).reshape(-1, 3)
        result |= caster.contains(points).reshape(result.shape)
    return result


def _roomiest(blocked: Flags) -> Ints:
    """Per row, the first of the free angles farthest from any blocked one; 0 if none is free."""
    angles = blocked.shape[1]
    room = np.zeros(blocked.shape, dtype=int)
    near = blocked.copy()
    for step in range(1, angles // 2 + 2):
        room += ~near
        near = near | np.roll(blocked, step, axis=1) | np.roll(blocked, -step, axis=1)
    return np.asarray(room.argmax(axis=1))

"""Which loads a suction cup resists: the linear limits of Dex-Net 3.0 (Mahler et al. 2018).

A load is the wrench of the object on the cup, in the frame of the cup: force, then torque about the
origin. z is the approach: a positive force along it pulls the object off. The contact of one cup
has six coordinates, which are those of its load. So a load is resisted if it satisfies the limits
itself, and no optimization problem has to be solved.

The robust quality is the share of perturbed copies that hold: as in Dex-Net 3.0, the pose of the
object, the pose of the cup, the friction and the load are uncertain.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from egad._util.arrays import Flags, Floats, Ints
from egad.geometry import RayCaster
from egad.grasps.parameters import RobustSuction
from egad.grasps.suction.seal import seal_cups
from egad.grippers import SuctionCup
from egad.random import generator


class CupLimits(NamedTuple):
    """The largest value of each component of a load that a cup resists, if the others are 0."""

    pull: float  # along its axis, newtons
    across: float  # along x or y, newtons
    torsion: float  # about its axis, newton metres
    bending: float  # about x or y, newton metres, with the tolerance


def limits(cup: SuctionCup) -> CupLimits:
    """The limits of a cup: see `resists`."""
    grip = cup.friction * cup.vacuum_force / np.sqrt(3)
    bending = _bending(cup) + cup.torque_tolerance
    return CupLimits(cup.vacuum_force, grip, cup.radius * grip, bending)


def resists(cup: SuctionCup, loads: Floats, friction: ArrayLike | None = None) -> Flags:
    """Whether a cup resists each of n loads (n, 6), newtons and newton metres.

    With the force `N = V - f_z` that presses the cup on, the eleven limits are
    `sqrt(3) |f_x| <= mu N`, `sqrt(3) |f_y| <= mu N` (friction), `sqrt(3) |t_z| <= r mu N`
    (torsion), `sqrt(2) |t_x| <= pi r kappa`, `sqrt(2) |t_y| <= pi r kappa` (bending) and `N >= 0`
    (vacuum). The bending torque may lie outside its limits by `torque_tolerance`.
    """
    pressing = cup.vacuum_force - loads[:, 2]
    mu = np.asarray(cup.friction if friction is None else friction)
    grip = mu * pressing / np.sqrt(3)
    held = (pressing >= 0) & (np.abs(loads[:, :2]).max(axis=1) <= grip)
    held &= np.abs(loads[:, 5]) <= cup.radius * grip
    beyond = np.maximum(np.abs(loads[:, 3:5]) - _bending(cup), 0.0)
    return np.asarray(held & (np.hypot(beyond[:, 0], beyond[:, 1]) <= cup.torque_tolerance))


def _bending(cup: SuctionCup) -> float:
    """The bending torque of the paper, newton metres."""
    return float(np.pi * cup.radius * cup.bending / np.sqrt(2))


def loads_in_frames(origins: Floats, frames: Floats, forces: Floats, points: Floats) -> Floats:
    """Loads (n, 6) of forces, N, at points, m, in the frames of n cups (`seal_cups`)."""
    force = np.broadcast_to(forces, origins.shape)
    both = np.stack([force, np.cross(points - origins, force)], axis=1)
    turned = np.einsum("nij,nkj->nki", frames, both)
    return np.asarray(turned.reshape(len(origins), 6))


RANDOM_NUMBERS = 17  # of a copy: five vectors, friction, weight


def robust_suction_quality(
    caster: RayCaster,
    cup: SuctionCup,
    origins: Floats,  # (n, 3) of the frames of the cups, metres
    frames: Floats,  # (n, 3, 3) their unit vectors x, y, z in rows
    com: Floats,  # (3,) metres
    weights: Floats,  # (n, 3) weight of the object as a vector, newtons
    *,
    robust: RobustSuction,
    seed: int,
    indices: Ints,  # (n,) identify the grasps in the random streams
) -> Floats:
    """The share of perturbed copies of each of n grasps that seal and resist the load, (n,)."""
    size = (robust.samples, RANDOM_NUMBERS)
    streams = [generator(seed, "robust_suction_quality", int(index)) for index in indices]
    drawn = np.concatenate([np.empty((0, size[1])), *(rng.normal(size=size) for rng in streams)])
    cup_shift, cup_turn, shift, turn, com_shift = np.split(drawn[:, :15], 5, axis=1)
    owners = np.repeat(np.arange(len(origins)), robust.samples)
    frame = frames[owners]
    # from here on in the frame of the cup before it is perturbed
    center = np.einsum("nij,nj->ni", frame, com - origins[owners])
    back = Rotation.from_rotvec(robust.object_rotation_sigma * turn).inv()
    turned_cup = Rotation.from_rotvec(robust.cup_rotation_sigma * cup_turn)
    moved = robust.cup_translation_sigma * cup_shift - robust.object_translation_sigma * shift
    places = back.apply(moved - center) + center
    axes = (back * turned_cup).as_matrix().transpose(0, 2, 1)
    force = back.apply(np.einsum("nij,nj->ni", frame, weights[owners]))
    force *= np.maximum(1 + robust.weight_sigma * drawn[:, 16:], 0.0)
    friction = np.maximum(cup.friction + robust.friction_sigma * drawn[:, 15], 0.0)
    # and back in the frame of the object
    there = origins[owners] + np.einsum("nij,ni->nj", frame, places)
    seals = seal_cups(caster, cup, there, np.einsum("nki,nij->nkj", axes, frame))
    held = np.flatnonzero(seals.sealed)
    contacts = places[held] + seals.depths[held, None] * axes[held, 2]
    at = center[held] + robust.com_sigma * com_shift[held]
    loads = loads_in_frames(contacts, axes[held], force[held], at)
    success = np.zeros(len(owners))
    success[held] = resists(cup, loads, friction[held])
    return np.asarray(success.reshape(len(origins), robust.samples).mean(axis=1))

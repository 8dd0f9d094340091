"""Which loads a suction cup resists: the linear limits of Dex-Net 3.0 (Mahler et al. 2018).

A load is the wrench of the object on the cup, in the frame of the cup: force, then torque about the
origin. z is the approach: a positive force along it pulls the object off. The contact of one cup
has six coordinates, which are those of its load. So a load is resisted if it satisfies the limits
itself, and no optimization problem has to be solved.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from egad._util.arrays import Flags, Floats
from egad.grippers import SuctionCup


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
    """Whether a cup resists each of n loads.

    With the force `N = V - f_z` that presses the cup on, the eleven limits are
    `sqrt(3) |f_x| <= mu N`, `sqrt(3) |f_y| <= mu N` (friction), `sqrt(3) |t_z| <= r mu N`
    (torsion), `sqrt(2) |t_x| <= pi r kappa`, `sqrt(2) |t_y| <= pi r kappa` (bending) and `N >= 0`
    (vacuum). The bending torque may lie outside its limits by `torque_tolerance`.

    Args:
        cup: The cup.
        loads: (n, 6) force and torque, newtons and newton metres.
        friction: mu, one for all or (n,); by default that of the cup.
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

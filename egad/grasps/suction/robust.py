"""Quality of suction grasps under uncertainty: the share of perturbed copies that hold.

As in Dex-Net 3.0 (Mahler et al. 2018), the pose of the object, the pose of the cup, the friction
and the load are uncertain.
"""

import numpy as np
from scipy.spatial.transform import Rotation

from egad._util.arrays import Floats, Ints
from egad.geometry import RayCaster
from egad.grasps.parameters import RobustSuction
from egad.grasps.suction.seal import seal_cups
from egad.grasps.suction.wrench import loads_in_frames, resists
from egad.grippers import SuctionCup
from egad.random import generator

RANDOM_NUMBERS = 17  # of a copy: five vectors, friction, weight


def robust_suction_quality(
    caster: RayCaster,
    cup: SuctionCup,
    origins: Floats,
    frames: Floats,
    com: Floats,
    weights: Floats,
    *,
    robust: RobustSuction,
    seed: int,
    indices: Ints,
) -> Floats:
    """The share of perturbed copies of each of n grasps that seal and resist the load, (n,).

    In every copy, the object rotates about its center of mass and shifts, the cup rotates and
    shifts, and friction, weight and center of mass differ. The copies of a grasp depend on the seed
    and its index, in the frame of its cup, but not on the other grasps.

    Args:
        caster: Ray caster of the object, closed, metres.
        cup: The cup.
        origins: (n, 3) origins of the frames of the cups, metres.
        frames: (n, 3, 3) their unit vectors x, y, z in rows.
        com: (3,) center of mass, metres.
        weights: (n, 3) weight of the object as a vector, newtons.
        robust: Number of copies and their spread.
        seed: Seed of the copies.
        indices: (n,) identify the grasps in the random streams.
    """
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

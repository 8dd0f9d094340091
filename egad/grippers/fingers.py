"""Find the two fingers of a described hand: what moves, and which way."""

from collections.abc import Iterable, Iterator
from itertools import product
from typing import NamedTuple

import mujoco
import numpy as np

from egad._util.arrays import Floats
from egad.errors import UserError
from egad.grippers.description import shapes_of
from egad.grippers.mechanism import Mechanism, body_name, joint_name, subtree

SMALL_STEP = 1e-3  # of the stroke
STANDING = 1e-7  # metres; fingers that move less in a small step stand still
SPREAD = 0.5  # of the closing speed: links that move more than this across it are not two fingers
SNAP = 2.0  # degrees; axes this close to one of the palm's axes are taken to be that axis
MAX_DRIVEN = 4
WHOLE_ROBOT = "; for a whole robot, name a link of each finger: finger_links: [NAME, NAME]"


class Sides(NamedTuple):
    """The moving links of both fingers, and the axis along which they close."""

    links: tuple[frozenset[int], frozenset[int]]  # of fingers at the lower and higher end
    axis: Floats  # unit vector in the frame of the palm
    signs: Floats  # which way each driven joint moves from open to closed, (n,)


def find_driven(model: mujoco.MjModel, joints: list[int], wanted: str | None = None) -> list[int]:
    """The driven joints: those with an actuator, or else that mimic no other; or `UserError`."""
    names = {joint_name(model, joint): joint for joint in joints}
    if wanted is not None:
        if wanted not in names:
            raise UserError(f"joint is {wanted!r}; the hand has {', '.join(names)}")
        driven = [names[wanted]]
    else:
        mimics = (model.eq_type == mujoco.mjtEq.mjEQ_JOINT) & (model.eq_obj2id >= 0)
        free = set(joints) - set(map(int, model.eq_obj1id[mimics]))
        driven = sorted(_actuated(model) & set(joints)) or sorted(free)
    if not driven:
        raise UserError(f"each of its joints mimics another one: {', '.join(names)}")
    for joint in driven:
        name, (low, high) = joint_name(model, joint), model.jnt_range[joint]
        if low > high:
            raise UserError(f"the joint {name} cannot move: its lower limit is above its upper one")
        if not model.jnt_limited[joint] or not np.isfinite([low, high]).all():
            raise UserError(
                f"the joint {name} has no limits, or equal ones; it needs a "
                f"lower and an upper limit{WHOLE_ROBOT}"
            )
    if len(driven) > MAX_DRIVEN:
        raise UserError(
            f"it has {len(driven)} independent joints "
            f"({', '.join(joint_name(model, joint) for joint in driven)}); name the one that "
            f"closes the hand: joint: NAME{WHOLE_ROBOT}"
        )
    return driven


def find_moving_jaw(mechanism: Mechanism, chains: list[int]) -> int | None:
    """The only moving link of a hand, if one joint moves it against the rest; None otherwise."""
    model = mechanism.model
    groups = [subtree(model, chain) for chain in chains]
    solid = [each for each in groups if any(shapes_of(model, body) for body in each)]
    if len(solid) != 1 or mechanism.followers or len(mechanism.driven) != 1:
        return None
    (body,) = [each for each in solid[0] if model.body_jntnum[each]]
    return body if all(each == body or not shapes_of(model, each) for each in solid[0]) else None


def find_sides(mechanism: Mechanism, chains: list[int]) -> Sides:
    """Which links belong to which finger: those that move against each other along a line."""
    model = mechanism.model
    groups = [frozenset(subtree(model, chain)) for chain in chains]
    solid = [group for group in groups if any(shapes_of(model, body) for body in group)]
    names = ", ".join(body_name(model, min(group)) for group in solid or groups)
    if not solid:
        raise UserError(f"its moving links have no collision shapes: {names}")
    if len(solid) < 2:
        raise UserError(f"only one finger moves, with the link {names}; two are needed")
    motions = _motions(mechanism, solid)
    motion = max(motions, key=lambda each: float(each.sizes[0]), default=None)
    if (
        motion is None
        or motion.sizes[0] < STANDING
        or motion.sizes[1:2].sum() > SPREAD * motion.sizes[0]
    ):
        raise UserError(f"its links {names} do not move as two fingers that close along a line")
    axis = snapped(motion.axis)
    axis *= np.sign(axis[np.abs(axis).argmax()])
    places = motion.before @ axis
    higher = places > (places.min() + places.max()) / 2
    closing = np.sign((places - motion.after @ axis)[higher].sum())
    first, second = (
        frozenset().union(*(group for group, high in zip(solid, higher, strict=True) if high == on))
        for on in (False, True)
    )
    return Sides((first, second), axis, motion.signs * closing)


class _Motion(NamedTuple):
    """A small step of the driven joints that the other joints can follow."""

    sizes: Floats  # how far groups of links move against each other, along each axis, descending
    axis: Floats  # the axis along which they move most
    before: Floats  # (n, 3) the middles of the groups before the step
    after: Floats  # the same after it
    signs: Floats  # which way each driven joint moves, (n,)


def _motions(mechanism: Mechanism, groups: list[frozenset[int]]) -> Iterator[_Motion]:
    """The steps from the middle of the stroke, with each driven joint moving either way."""
    middle, span = mechanism.ranges().mean(axis=1), np.ptp(mechanism.ranges(), axis=1)
    near = mechanism.middle()
    for others in product((1.0, -1.0), repeat=len(span) - 1):
        signs = np.array([1.0, *others])
        step = signs * span * SMALL_STEP
        pair = [mechanism.follow(middle + way * step, near) for way in (-1, 1)]
        if len(span) == 1:
            for each in pair:
                mechanism.check(each)
        elif not all(map(mechanism.holds, pair)):
            continue
        before, after = (
            np.array([points_of(mechanism, each, sorted(group)).mean(axis=0) for group in groups])
            for each in pair
        )
        speeds = (after - before) - (after - before).mean(axis=0)
        _, sizes, axes = np.linalg.svd(speeds)
        yield _Motion(sizes, axes[0], before, after, signs)


def snapped(axis: Floats) -> Floats:
    """A unit vector, or the axis of the frame that it is close to."""
    largest = int(np.abs(axis).argmax())
    if abs(axis[largest]) < np.cos(np.radians(SNAP)) * np.linalg.norm(axis):
        return np.asarray(axis / np.linalg.norm(axis))
    return np.asarray(np.sign(axis[largest]) * np.eye(3)[largest])


def _actuated(model: mujoco.MjModel) -> set[int]:
    """Joints that an actuator moves, by itself or through a tendon."""
    joints: set[int] = set()
    for kind, (target, _) in zip(model.actuator_trntype, model.actuator_trnid, strict=True):
        if kind == mujoco.mjtTrn.mjTRN_JOINT:
            joints.add(int(target))
        elif kind == mujoco.mjtTrn.mjTRN_TENDON:
            first = model.tendon_adr[target]
            wraps = slice(first, first + model.tendon_num[target])
            moved = model.wrap_type[wraps] == mujoco.mjtWrap.mjWRAP_JOINT  # others are sites, geoms
            joints |= set(map(int, model.wrap_objid[wraps][moved]))
    return joints


def points_of(mechanism: Mechanism, positions: Floats, bodies: Iterable[int]) -> Floats:
    """Points (n, 3) of the shapes of links, in the frame of the palm, metres."""
    turns, places = mechanism.placement(positions)
    shapes = ((body, shape) for body in bodies for shape in shapes_of(mechanism.model, body))
    return np.concatenate([shape @ turns[body].T + places[body] for body, shape in shapes])

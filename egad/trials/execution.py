"""Carrying out one grasp on an object where it lies."""

from contextlib import nullcontext
from typing import NamedTuple

import numpy as np

from egad.settings import Gripper, Lifting
from egad.trials.carriers import CARRIERS, Stance, UnreachableError
from egad.trials.grasp import Grasp
from egad.trials.hand import HEAVIEST, Hand
from egad.trials.stillness import Stillness
from egad.trials.world import GRAVITY, Pose, UnstableError, World

START_ABOVE = 0.02  # fingertips start this far above the object
DESCENT_SPEED = 0.25  # mean, m/s
LIFT_SPEED = 0.35  # mean, m/s


class Execution(NamedTuple):
    """What came of a grasp.

    Attributes:
        outcome: success: held up to the end; collided: stopped on the way, or out of the arm's
            reach; missed: the fingers closed, but never pressed on the object both at once;
            slipped_closing: they did, and lost it before it was lifted; slipped_lifting: lost
            while lifting; dropped: lost while held up; failed: the simulation broke down.
        lifted: Height that the object's centre of mass gained, metres.
        end: Where the object is at last; None if the simulation broke down. Of an object that lay
            still in the hand before it was lifted all the way, where it would be then.
    """

    outcome: str
    lifted: float
    end: Pose | None


def execute(
    world: World, gripper: Gripper, lifting: Lifting, grasp: Grasp, *, afloat: bool = False
) -> Execution:
    """Approach from above, close, lift and hold.

    It depends on the arguments alone, if the world was reset before the object was placed.

    Args:
        world: With the object where it is to be grasped.
        gripper: The hand; it is added to the world.
        lifting: Arm, lift and hold.
        grasp: One that the hand can do (`Grasp.flaw`).
        afloat: Whether the object floats in the air: held there until the hand has come, free but
            without weight until the fingers have closed.
    """
    try:
        before = world.pose().position[2]
        outcome, end = _outcome(world, gripper, lifting, grasp, afloat)
    except UnstableError:
        return Execution("failed", 0.0, None)
    return Execution(outcome, float(end.position[2] - before), end)


def _outcome(
    world: World, gripper: Gripper, lifting: Lifting, grasp: Grasp, afloat: bool
) -> tuple[str, Pose]:
    start = max(float(world.vertices()[:, 2].max()) + START_ABOVE, grasp.tip)
    try:
        hand = hung(world, gripper, lifting.arm, grasp, start)
    except UnreachableError:
        return "collided", world.pose()
    world.pull(0.0 if afloat else GRAVITY)
    with world.pinned() if afloat else nullcontext():
        if not hand.move(grasp.tip, (start - grasp.tip) / DESCENT_SPEED):
            return "collided", world.pose()
    touched = hand.close()
    world.pull(GRAVITY)
    if not hand.pinches():
        return "slipped_closing" if touched else "missed", world.pose()
    return _carried(hand, lifting)


def _carried(hand: Hand, lifting: Lifting) -> tuple[str, Pose]:
    """Lift and hold; what lies still in the hand stays there, and need not be simulated on."""
    height, seconds = lifting.lift_height, lifting.lift_height / LIFT_SPEED
    still = Stillness(hand, HEAVIEST * seconds, seconds + lifting.hold_time)
    arrived = hand.lift(height, seconds, still)
    if not hand.carries():
        return "slipped_lifting", hand.world.pose()
    if not arrived:
        return "collided", hand.world.pose()
    if not hand.path_left:
        hand.hold(lifting.hold_time, still)
    outcome, pose = "success" if hand.carries() else "dropped", hand.world.pose()
    rise = hand.path_left[-1] - hand.height() if hand.path_left else 0.0
    if hand.world.watch is not None:
        hand.go_on(lifting.hold_time)
    return outcome, Pose(pose.position + np.array([0.0, 0.0, rise]), pose.quaternion)


def hung(world: World, gripper: Gripper, arm: str, grasp: Grasp, height: float) -> Hand:
    """The open hand, its fingertips at some height above a grasp.

    Raises:
        UnreachableError: The arm cannot bring it there.
    """
    stance = Stance(grasp.center[0], grasp.center[1], height, grasp.angle)
    return Hand(world, gripper, CARRIERS[arm](world, gripper, stance), grasp.width)

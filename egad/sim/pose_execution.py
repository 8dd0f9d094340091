"""A hand without an arm, which moves along its approach to a grasp and away with the object."""

import math
from typing import NamedTuple

import numpy as np

from egad._util.arrays import Floats
from egad.detectors import SEARCH
from egad.sim.cup import FREE
from egad.sim.parameters import COLLISION_FORCE
from egad.sim.world import UnstableError, World
from egad.tables.outcomes import Outcome

# As in VGN's repository (Breyer et al. 2020), unless it says "ours".
STANDOFF = 0.05  # metres before the grasp, where the approach begins
RETREAT = 0.1  # metres
STEEP = np.radians(60)  # off the vertical; hands with flatter approaches retreat upwards
AT_REST = 0.001  # ours: metres; a hand that moved less is still where it was placed
UP = np.array([0.0, 0.0, 1.0])
APPROACH_SPEED, RETREAT_SPEED = 0.25, 0.35  # ours: mean, m/s


class PoseExecution(NamedTuple):
    """The result of a grasp.

    Attributes:
        outcome: Success; collided: the hand was stopped on its way and held nothing in the end;
            missed, slipped_closing or slipped_lifting; for a suction cup no_seal; failed.
        held: Number of the object in the hand; None without success.
        stopped: How far before the grasp the hand was stopped, metres.
    """

    outcome: Outcome
    held: int | None = None
    stopped: float = 0.0


class ContactRules(NamedTuple):
    """What contacts mean; see `ClutterProtocol`.

    Attributes:
        contact: What a contact during the approach means: close, fail or ignore.
        force: Contacts above this force count, newtons.
        pinched: Whether both fingers must press on an object after they closed.
        first: Whether the object that is held is the first one that the hand touches.
    """

    contact: str = "close"
    force: float = COLLISION_FORCE
    pinched: bool = True
    first: bool = False


DEFAULT_CONTACTS = ContactRules()


def execute_pose(
    world: World, pose: Floats, width: float, rules: ContactRules = DEFAULT_CONTACTS
) -> PoseExecution:
    """Approach from 5 cm away, close, and retreat by 10 cm; `rules` say what a contact does.

    A suction cup goes up to 1 cm further to find an object. For it, closing means switching the
    vacuum on.

    A hand that approaches from above, within 60 degrees, retreats along its approach; otherwise it
    moves straight up. An object is held if the hand then touches it and is not closed.

    The result depends only on the arguments, if the world was reset before the objects were placed.

    Args:
        world: World with the objects where they lie, and the robot `egad.sim.robots.free_hand`.
        pose: (4, 4) from the frame of the hand (`egad.grasps.Grasps.poses`) to the world.
        width: How far the hand opens, metres.
        rules: What contacts mean.
    """
    try:
        return _executed(world, pose, width, rules)
    except UnstableError:
        return PoseExecution(Outcome.FAILED)


def _executed(world: World, pose: Floats, width: float, rules: ContactRules) -> PoseExecution:
    approach = pose[:3, 2]
    start = pose.copy()
    start[:3, 3] -= STANDOFF * approach
    kind = world.known_robot.gripper.kind
    hand = FREE[kind.name](world, start, width)
    limit = math.inf if rules.contact == "ignore" else rules.force
    way = STANDOFF + (0.0 if kind.closes else SEARCH)
    try:
        world.step()
        if hand.touches():
            return PoseExecution(Outcome.COLLIDED, stopped=STANDOFF)
        stopped = hand.move(way * approach, APPROACH_SPEED, limit)
    except UnstableError:
        if rules.contact != "fail" or hand.moved() > AT_REST:
            raise
        # a hand placed inside an object throws it away at once
        return PoseExecution(Outcome.COLLIDED, stopped=STANDOFF)
    if stopped and rules.contact == "fail":
        return PoseExecution(Outcome.COLLIDED, stopped=stopped)
    touched, pinched = hand.close(), hand.pinches()
    if pinched or not rules.pinched:
        back = -approach if -approach[2] >= np.cos(STEEP) else UP
        hand.move(RETREAT * back, RETREAT_SPEED)
        held = hand.held(first=rules.first)
        if held is not None:
            return PoseExecution(Outcome.SUCCESS, held, stopped)
    if stopped:
        return PoseExecution(Outcome.COLLIDED, stopped=stopped)
    if pinched:
        return PoseExecution(Outcome.SLIPPED_LIFTING)
    return PoseExecution(hand.loss(touched))

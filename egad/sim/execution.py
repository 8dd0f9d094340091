"""Executing one grasp: approach, close, and lift.

A hand on an arm comes from above and holds the object until it has come to rest. A hand without an
arm moves along its approach to a grasp and away. For a suction cup, closing means switching the
vacuum on.
"""

import math
from contextlib import nullcontext
from typing import NamedTuple

import numpy as np

from egad._util.arrays import Floats
from egad.detectors import SEARCH, Grasp
from egad.grasps import FIXED_SIDE_CLEARANCE, expected_distance
from egad.sim.arms import Arm, HandPose, UnreachableError
from egad.sim.cup import FREE, ON_ARM
from egad.sim.jaws import HEAVIEST, Hand
from egad.sim.parameters import COLLISION_FORCE, Contact, Lifting
from egad.sim.world import DOWN, TIME_STEP, WEIGHTLESS, Pose, UnstableError, World
from egad.tables.outcomes import Outcome

START_ABOVE = 0.02  # fingertips start this far above the object
DESCENT_SPEED = 0.25  # mean, m/s
LIFT_SPEED = 0.35  # mean, m/s
# Motion is measured over some time, not at an instant: a swinging object stands still at its
# turning points. Around such a point, a pendulum of 5 cm still moves by a quarter of its amplitude.
WINDOW = 0.1  # seconds
STRIDE = 6  # steps from one check to the next
CREEP = 0.001  # metres that it may still move until the end, at the rate of the window


# Of a hand without an arm, as in VGN's repository (Breyer et al. 2020), unless it says "ours".
STANDOFF = 0.05  # metres before the grasp, where the approach begins
RETREAT = 0.1  # metres
STEEP = np.radians(60)  # off the vertical; hands with flatter approaches retreat upwards
AT_REST = 0.001  # ours: metres; a hand that moved less is still where it was placed
UP = np.array([0.0, 0.0, 1.0])
APPROACH_SPEED, RETREAT_SPEED = 0.25, 0.35  # ours: mean, m/s


class ContactRules(NamedTuple):
    """What contacts during the approach mean, and when a hand without an arm holds an object."""

    contact: Contact  # what a contact means
    force: float = COLLISION_FORCE  # contacts above this force count, newtons
    pinched: bool = True  # whether both fingers must press on an object after they closed
    first: bool = False  # whether the object that is held is the first one that the hand touches

    @property
    def limit(self) -> float:
        """Contact force that stops the hand, newtons."""
        return math.inf if self.contact == "ignore" else self.force


FAILS, CLOSES = ContactRules("collided"), ContactRules("close")


class Execution(NamedTuple):
    """The result of a grasp."""

    # one of `egad.tables.outcomes.EXECUTION`, or failed; for a suction cup also no_seal
    outcome: Outcome
    lifted: float = 0.0  # height that the object's center of mass gained, metres
    # final pose of the object; None if the simulation broke down. If the object lay still in the
    # hand before the lift was complete, where it would be after the whole lift
    end: Pose | None = None
    # how far before the grasp a contact stopped the hand, metres; 0 if none did
    stopped: float = 0.0
    # number of the object in a hand without an arm; None without success. For such a hand, `lifted`
    # and `end` are not known
    held: int | None = None


def execute(
    world: World,
    arm: Arm,
    lifting: Lifting,
    grasp: Grasp,
    *,
    afloat: bool = False,
    contact: float | None = None,
    rules: ContactRules = FAILS,
) -> Execution:
    """Approach from above, close, lift and hold.

    An object that is `afloat` is held in the air until the hand has arrived, then weightless until
    the fingers have closed. `contact` is the distance of the pads at which they will meet it,
    metres, if known: pads may move on arcs.

    The result depends only on the arguments, if the world was reset before the object was placed.
    """
    try:
        before = world.pose().position[2]
        outcome, end, stopped = _outcome(world, arm, lifting, grasp, afloat, contact, rules)
    except UnstableError:
        return Execution(Outcome.FAILED)
    return Execution(outcome, float(end.position[2] - before), end, stopped)


def _outcome(
    world: World,
    arm: Arm,
    lifting: Lifting,
    grasp: Grasp,
    afloat: bool,
    contact: float | None,
    rules: ContactRules,
) -> tuple[Outcome, Pose, float]:
    start = max(float(world.vertices()[:, 2].max()) + START_ABOVE, grasp.tip)
    try:
        hand = place_hand_above(world, arm, grasp, start, contact)
    except UnreachableError:
        return Outcome.COLLIDED, world.pose(), 0.0
    world.set_gravity(WEIGHTLESS if afloat else DOWN)
    with world.pinned() if afloat else nullcontext():
        stopped = hand.move(grasp.tip, (start - grasp.tip) / DESCENT_SPEED, rules.limit)
    if stopped is not None:
        if rules.contact != "close":
            return Outcome.COLLIDED, world.pose(), stopped
        hand.yield_to_contact()
    touched = hand.close()
    world.set_gravity(DOWN)
    if hand.pinches():
        outcome, end = lift_and_hold(hand, lifting)
    else:
        outcome, end = hand.loss(touched), world.pose()
    return outcome, end, stopped or 0.0


def execute_pose(
    world: World, pose: Floats, width: float, rules: ContactRules = CLOSES
) -> Execution:
    """Approach from 5 cm away, close, and retreat by 10 cm; `rules` say what a contact does.

    The hand is a `free_hand` at `pose`, (4, 4) to the world, and opens by `width`, metres. A cup
    goes up to 1 cm further to find an object; closing switches its vacuum on. From above, within 60
    degrees, the hand retreats along its approach, otherwise straight up. An object is held if the
    hand then touches it and is not closed.

    The result depends only on the arguments, if the world was reset before the objects were placed.
    """
    try:
        return _executed(world, pose, width, rules)
    except UnstableError:
        return Execution(Outcome.FAILED)


def _executed(world: World, pose: Floats, width: float, rules: ContactRules) -> Execution:
    approach = pose[:3, 2]
    start = pose.copy()
    start[:3, 3] -= STANDOFF * approach
    kind = world.known_robot.gripper.kind
    hand = FREE[kind.name](world, start, width)
    way = STANDOFF + (0.0 if kind.closes else SEARCH)
    try:
        world.step()
        if hand.touches():
            return Execution(Outcome.COLLIDED, stopped=STANDOFF)
        stopped = hand.move(way * approach, APPROACH_SPEED, rules.limit)
    except UnstableError:
        if rules.contact != "collided" or hand.moved() > AT_REST:
            raise
        # a hand placed inside an object throws it away at once
        return Execution(Outcome.COLLIDED, stopped=STANDOFF)
    if stopped and rules.contact == "collided":
        return Execution(Outcome.COLLIDED, stopped=stopped)
    touched, pinched = hand.close(), hand.pinches()
    if pinched or not rules.pinched:
        back = -approach if -approach[2] >= np.cos(STEEP) else UP
        hand.move(RETREAT * back, RETREAT_SPEED)
        held = hand.held(first=rules.first)
        if held is not None:
            return Execution(Outcome.SUCCESS, stopped=stopped, held=held)
    if stopped:
        return Execution(Outcome.COLLIDED, stopped=stopped)
    if pinched:
        return Execution(Outcome.SLIPPED_LIFTING)
    return Execution(hand.loss(touched))


def lift_and_hold(hand: Hand, lifting: Lifting) -> tuple[Outcome, Pose]:
    """Lift and hold; an object that lies still in the hand stays there: simulation ends early."""
    height, seconds = lifting.lift_height, lifting.lift_height / LIFT_SPEED
    still = Stillness(hand, HEAVIEST * seconds, seconds + lifting.hold_time)
    arrived = hand.lift(height, seconds, still)
    if not hand.carries():
        return Outcome.SLIPPED_LIFTING, hand.world.pose()
    if not arrived:
        return Outcome.COLLIDED, hand.world.pose()
    if not hand.path_left:
        hand.hold(lifting.hold_time, still)
    outcome = Outcome.SUCCESS if hand.carries() else Outcome.DROPPED
    pose = hand.world.pose()
    rise = hand.path_left[-1] - hand.height() if hand.path_left else 0.0
    if hand.world.watch is not None:
        hand.go_on(lifting.hold_time)
    return outcome, Pose(pose.position + np.array([0.0, 0.0, rise]), pose.quaternion)


def place_hand_above(
    world: World, arm: Arm, grasp: Grasp, height: float, contact: float | None = None
) -> Hand:
    """Open the hand above a grasp, fingertips at some height, or raise UnreachableError.

    A fixed jaw is `JAW_CLEARANCE` before its contact, or `FIXED_SIDE_CLEARANCE` if the opening of
    the grasp tells where that is: it is 8 mm wider on each side.
    """
    hand_pose = HandPose(grasp.center[0], grasp.center[1], height, grasp.angle)
    gripper = arm.robot.gripper
    hand = ON_ARM[gripper.kind.name]
    if contact is not None or arm.robot.drive.mirrored:
        return hand(world, arm, hand_pose, grasp.width, contact)
    expected = expected_distance(grasp.width, gripper)
    return hand(world, arm, hand_pose, grasp.width, expected, FIXED_SIDE_CLEARANCE)


class _Held(NamedTuple):
    """Position and quaternion of the object, seen from the hand, and how far the hand is open."""

    position: Floats
    quaternion: Floats
    opening: float


class Stillness:
    """Tells when an object has come to rest in a hand that is level and does not turn."""

    def __init__(self, hand: Hand, start: float, end: float) -> None:
        """Watch the object: it cannot be at rest before `start`, and must stay until `end`, s."""
        self._hand = hand
        points = hand.world.model.mesh.vertices  # the origin is the center of mass
        self._reach = float(np.linalg.norm(points, axis=1).max())
        self._early, self._left = round(start / TIME_STEP), round(end / TIME_STEP)
        self._window = round(WINDOW / TIME_STEP)
        self._before, self._steps = self._held(), 0

    def __call__(self) -> bool:
        """Whether the object lies still: no point will move by 1 mm until the end."""
        self._early, self._left, self._steps = self._early - 1, self._left - 1, self._steps + 1
        if self._early == 0:
            self._before, self._steps = self._held(), 0
        if self._early >= 0 or self._steps % STRIDE:
            return False
        allowed = CREEP * self._window / max(self._left, self._window)
        if self._motion() > allowed:
            self._before, self._steps = self._held(), 0
        return self._steps >= self._window

    def _held(self) -> _Held:
        pose = self._hand.world.pose()
        below = np.array([0.0, 0.0, self._hand.height()])
        return _Held(pose.position - below, pose.quaternion, self._hand.opening())

    def _motion(self) -> float:
        """Upper bound of the motion of any point of the object relative to the hand, metres."""
        now, before = self._held(), self._before
        shift = float(np.linalg.norm(now.position - before.position))
        # For small rotations, the distance of two unit quaternions is half the angle between them.
        ways = (now.quaternion - before.quaternion, now.quaternion + before.quaternion)
        angle = 2 * min(float(np.linalg.norm(way)) for way in ways)
        return shift + angle * self._reach + abs(now.opening - before.opening)

"""Executing one grasp: approach, close, lift, and hold until the object has come to rest.

For a suction cup, closing means switching the vacuum on.
"""

from contextlib import nullcontext
from typing import NamedTuple

import numpy as np

from egad._util.arrays import Floats
from egad.detectors import Grasp
from egad.grasps import FIXED_SIDE_CLEARANCE, expected_distance
from egad.sim.arms import Arm, HandPose, UnreachableError
from egad.sim.cup import ON_ARM
from egad.sim.gripper import HEAVIEST, Hand
from egad.sim.parameters import COLLISION_FORCE, Lifting
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


class Stopping(NamedTuple):
    """What a contact on the way down means.

    Attributes:
        force: Contact force that stops the hand, newtons.
        closes: Whether the fingers close there; otherwise the attempt has failed.
    """

    force: float = COLLISION_FORCE
    closes: bool = False


FAILS = Stopping()


class Execution(NamedTuple):
    """The result of a grasp.

    Attributes:
        outcome: One of `egad.tables.outcomes.EXECUTION`, or failed; for a suction cup also no_seal.
        lifted: Height that the object's center of mass gained, metres.
        end: Final pose of the object; None if the simulation broke down. If the object lay still in
            the hand before the lift was complete, where it would be after the whole lift.
        stopped: How far before the grasp a contact stopped the hand, metres; 0 if none did.
    """

    outcome: Outcome
    lifted: float
    end: Pose | None
    stopped: float = 0.0


def execute(
    world: World,
    arm: Arm,
    lifting: Lifting,
    grasp: Grasp,
    *,
    afloat: bool = False,
    contact: float | None = None,
    stopping: Stopping = FAILS,
) -> Execution:
    """Approach from above, close, lift and hold.

    The result depends only on the arguments, if the world was reset before the object was placed.

    Args:
        world: World with the object where it is to be grasped.
        arm: Arm that carries the hand; its robot is that of the world.
        lifting: Settings of lift and hold.
        grasp: A grasp that the hand can execute (`Grasp.flaw`).
        afloat: Whether the object floats in the air: it is held there until the hand has arrived,
            then free but weightless until the fingers have closed.
        contact: Distance of the pads at which they will meet the object, metres, if it is known;
            the height of the hand is then corrected for pads that move on arcs.
        stopping: What a contact on the way down means.
    """
    try:
        before = world.pose().position[2]
        outcome, end, stopped = _outcome(world, arm, lifting, grasp, afloat, contact, stopping)
    except UnstableError:
        return Execution(Outcome.FAILED, 0.0, None)
    return Execution(outcome, float(end.position[2] - before), end, stopped)


def _outcome(
    world: World,
    arm: Arm,
    lifting: Lifting,
    grasp: Grasp,
    afloat: bool,
    contact: float | None,
    stopping: Stopping,
) -> tuple[Outcome, Pose, float]:
    start = max(float(world.vertices()[:, 2].max()) + START_ABOVE, grasp.tip)
    try:
        hand = place_hand_above(world, arm, grasp, start, contact)
    except UnreachableError:
        return Outcome.COLLIDED, world.pose(), 0.0
    world.set_gravity(WEIGHTLESS if afloat else DOWN)
    with world.pinned() if afloat else nullcontext():
        stopped = hand.move(grasp.tip, (start - grasp.tip) / DESCENT_SPEED, stopping.force)
    if stopped is not None:
        if not stopping.closes:
            return Outcome.COLLIDED, world.pose(), stopped
        hand.yield_to_contact()
    touched = hand.close()
    world.set_gravity(DOWN)
    if hand.pinches():
        outcome, end = lift_and_hold(hand, lifting)
    else:
        outcome, end = hand.loss(touched), world.pose()
    return outcome, end, stopped or 0.0


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
    """Open the hand with its fingertips at some height above a grasp, or raise UnreachableError.

    A jaw that does not move is `JAW_CLEARANCE` before its contact. If it is not known where the
    hand will meet the object, the opening of the grasp tells: it is 8 mm wider on each side, and
    the jaw is `FIXED_SIDE_CLEARANCE` before its contact. A hand that opens as far as it can is in
    the middle.
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
        """Whether the object lies still; call this once after every step.

        It does if, at the rate of the last 0.1 s, none of its points would move by more than 1 mm
        until the end.
        """
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

"""A parallel-jaw hand: fingers that close with a force, and what they feel."""

from collections.abc import Callable

import numpy as np

from egad._util.arrays import Floats
from egad.grippers import JAW_CLEARANCE
from egad.outcomes import Outcome
from egad.sim.arms import Arm, HandPose
from egad.sim.protocols import COLLISION_FORCE
from egad.sim.robot import Robot
from egad.sim.world import TIME_STEP, World

CLOSING_TIME = 1.0
STALLED_SPEED = 0.0005
STALLED_STEPS = 24
# A rigid arm that stays where it met the table presses on, and friction holds the fingers there.
RECOIL = 0.001  # metres
SAGGING = 0.02  # metres that a hand may hang too low and still count as lifted
# The part of the time of a minimum-jerk path after which it speeds up most: when it is lifted, the
# object never bears more later on.
HEAVIEST = (3 - 3**0.5) / 6
Still = Callable[[], bool]


class Fingers:
    """The two fingers of a hand in a world, which move as mirror images, or of which one moves.

    Attributes:
        world: Where they are.
        gripper: What they are part of.
    """

    def __init__(self, world: World) -> None:
        """Take the robot of a world."""
        if world.robot is None:
            raise ValueError("there is no robot in this world")
        self.world = world
        self.gripper = world.robot.gripper

    def close(self) -> bool:
        """Close the fingers until they stall, and keep pressing with the gripper's force.

        Returns:
            Whether both of them pressed on an object at some time.
        """
        self.world.close_fingers()
        still, touched = 0, False
        for _ in range(round(CLOSING_TIME / TIME_STEP)):
            self.world.step()
            touched = touched or self.pinches()
            still = still + 1 if np.abs(self.world.fingers()[1]).max() < STALLED_SPEED else 0
            if still == STALLED_STEPS:
                break
        return touched

    def arrives(self) -> bool:
        """Whether the hand need not come any nearer: fingers come as far as they are told."""
        return False

    def loss(self, touched: bool) -> Outcome:
        """The outcome if nothing is held after `close`, given what this returned."""
        return Outcome.SLIPPED_CLOSING if touched else Outcome.MISSED

    def pinches(self) -> bool:
        """Whether both fingers press on an object."""
        forces = self.world.forces()
        return forces.left > 0 and forces.right > 0

    def opening(self) -> float:
        """Distance of the finger pads, metres."""
        return float(self.world.fingers()[0].sum())

    def carries(self) -> bool:
        """Whether the object touches the hand and not the table."""
        forces = self.world.forces()
        return forces.hand > 0 and not forces.support > 0


class Hand(Fingers):
    """Palm and fingers, carried by an arm.

    Attributes:
        arm: What carries it.
        path_left: Heights that `lift` left out.
    """

    def __init__(
        self,
        world: World,
        arm: Arm,
        hand_pose: HandPose,
        width: float,
        contact: float | None = None,
        clearance: float = JAW_CLEARANCE,
    ) -> None:
        """Open a hand that hangs in a world.

        Args:
            world: A world of the arm's robot; the hand is gone when it is reset.
            arm: What carries it.
            hand_pose: Where it is.
            width: Distance of the finger pads, metres.
            contact: That at which they will meet the object: the fingertips are where the hand_pose
                says when they are there; `width` if None.
            clearance: How far before its contact a jaw that does not move stands, metres, if the
                contact is known.

        Raises:
            UnreachableError: The arm cannot bring it there.
        """
        super().__init__(world)
        self.arm = arm
        self.path_left: list[float] = []
        self._stance = hand_pose
        self._raised = -arm.robot.reach(width if contact is None else contact)
        self._aside = _aside(arm.robot, width, contact, clearance)
        self._target = arm.joints(self._tip(hand_pose))
        world.put_robot(arm.base(self._tip(hand_pose)), self._target.tolist(), width)

    def steer(self, hand_pose: HandPose) -> None:
        """Steer the hand to a place above its base, to be there after the next step."""
        joints = self.arm.joints(self._tip(hand_pose), self._target)
        self.world.drive(joints.tolist(), ((joints - self._target) / TIME_STEP).tolist())
        self._target, self._stance = joints, hand_pose

    def move(self, height: float, seconds: float, limit: float = COLLISION_FORCE) -> float | None:
        """Move the fingertips to a height on a minimum-jerk path; stop at once at a collision.

        A suction cup stays where its ring lies on an object.

        Args:
            height: Metres above the table.
            seconds: How long it takes.
            limit: A contact force of more than this stops the hand, newtons.

        Returns:
            How far before that height it was stopped, metres; None if it got there.
        """
        for target in minimum_jerk(self.height(), height, seconds):
            self._raise_to(target)
            forces = self.world.forces()
            if forces.hand + forces.blocked > limit:
                return abs(self.height() - height)
            if self.arrives():
                self.yield_to_contact(0.0)
                break
        return None

    def yield_to_contact(self, recoil: float = RECOIL) -> None:
        """Go back and stay there, instead of pushing on."""
        height = self.height() + recoil
        for _ in range(2):  # there, and then with no speed
            self._raise_to(height)

    def lift(self, height: float, seconds: float, still: Still | None = None) -> bool:
        """Raise the fingertips by a height on a minimum-jerk path.

        Args:
            height: Metres.
            seconds: How long it takes.
            still: Asked after every step whether the object lies still in the hand. If so, and if
                nothing can stop the arm, the rest of the path is left out.

        Returns:
            Whether they got there: an arm has its reach, and its strength.
        """
        start = self._lift_from()
        path = minimum_jerk(start, start + height, seconds)
        for number, target in enumerate(path, 1):
            self._raise_to(target)
            if still and still() and self.arm.unstoppable and self.carries():
                self.path_left = path[number:]
                return True
        return self.height() > start + height - SAGGING

    def _lift_from(self) -> float:
        """Height at which a lift begins, metres."""
        return self.height()

    def hold(self, seconds: float, still: Still | None = None) -> None:
        """Stay there; only until the object is held and lies still, if this can be asked."""
        for _ in range(round(seconds / TIME_STEP)):
            self.world.step()
            if still and still() and self.carries():
                break

    def go_on(self, seconds: float) -> None:
        """Lift as far as was left out, and stay there: only for films, the outcome is known."""
        for target in self.path_left:
            self._raise_to(target)
        self.hold(seconds)

    def height(self) -> float:
        """Height of the fingertips above the table, metres."""
        return self.arm.height(self.world.arm_joints()) + self._raised

    def _tip(self, hand_pose: HandPose) -> HandPose:
        """Where the fingertips of the closed hand would be."""
        if self._aside:
            hand_pose = hand_pose._replace(
                x=hand_pose.x - self._aside * float(np.cos(hand_pose.angle)),
                y=hand_pose.y - self._aside * float(np.sin(hand_pose.angle)),
            )
        return (
            hand_pose._replace(height=hand_pose.height - self._raised)
            if self._raised
            else hand_pose
        )

    def _raise_to(self, height: float) -> None:
        self.steer(self._stance._replace(height=height))
        self.world.step()


def _aside(robot: Robot, width: float, contact: float | None, clearance: float) -> float:
    """How far the middle of the contacts lies beside TIP, along the closing axis, metres.

    A jaw that is fixed stands a little before its contact if it is known where that is; otherwise
    the open jaws are as far from the middle.
    """
    if robot.jaw is None or contact is None:
        return robot.aside(width)
    return robot.aside(contact) + clearance


def minimum_jerk(start: float, end: float, seconds: float) -> list[float]:
    """Positions, one a time step, from rest to rest (Flash and Hogan 1985)."""
    steps = max(round(seconds / TIME_STEP), 1)
    t = np.arange(1, steps + 1) / steps
    path: Floats = start + (end - start) * t**3 * (10 - 15 * t + 6 * t**2)
    return [float(place) for place in path]

"""Hands with jaws in a world: they close with a force, feel contacts, and move."""

import math
from collections.abc import Callable

import numpy as np
from scipy.spatial.transform import Rotation

from egad._util.arrays import Floats, dot_products
from egad.grippers import JAW_CLEARANCE
from egad.sim.arms import Arm, HandPose
from egad.sim.parameters import COLLISION_FORCE
from egad.sim.world import TIME_STEP, Pose, World
from egad.tables.outcomes import Outcome

CLOSING_TIME = 1.0
STALLED_SPEED = 0.0005
STALLED_STEPS = 24
# A rigid arm that stays where it met the table keeps pressing, so friction holds the fingers there.
RECOIL = 0.001  # metres
SAGGING = 0.02  # metres that a hand may hang too low and still count as lifted
# Fraction of the time of a minimum-jerk path at which acceleration peaks: a lifted object never
# bears a higher load afterwards.
HEAVIEST = (3 - 3**0.5) / 6
MIN_OPENING = 0.1  # of a free hand's opening; if closed further, the fingers hold nothing (VGN)
Still = Callable[[], bool]


class Fingers:
    """The two fingers of a hand in a world; they move as mirror images, or only one moves."""

    def __init__(self, world: World) -> None:
        """Take the robot of a world."""
        self.world = world
        self.gripper = world.known_robot.gripper

    def close(self) -> bool:
        """Close until the fingers stall, and press on; whether both pressed on an object."""
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
        """Whether the hand need not move any closer; always False for fingers."""
        return False

    def loss(self, touched: bool) -> Outcome:
        """The outcome if nothing is held after `close`, given what `close` returned."""
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
    """Palm and fingers, carried by an arm; `lift` skipped the heights in `path_left`."""

    def __init__(
        self,
        world: World,
        arm: Arm,
        hand_pose: HandPose,
        width: float,
        contact: float | None = None,
        clearance: float = JAW_CLEARANCE,
    ) -> None:
        """Open a hand in a world of the arm's robot, where it stays until the world is reset.

        The pads are `width` apart, metres. The fingertips are at `hand_pose` when they will meet
        the object, `contact` apart (default: `width`); a fixed jaw is `clearance` before a known
        contact. `UnreachableError` if the arm cannot bring the hand there.
        """
        super().__init__(world)
        self.arm = arm
        self.path_left: list[float] = []
        self._hand_pose = hand_pose
        self._raised = -arm.robot.reach(width if contact is None else contact)
        # the middle of the contacts beside TIP; open jaws of which one is fixed are as far from it,
        # unless it is known where they will meet the object
        drive = arm.robot.drive
        if contact is None or drive.mirrored:
            self._aside = drive.aside(width)
        else:
            self._aside = drive.aside(contact) + clearance
        self._target = arm.joints(self._tip(hand_pose))
        world.put_robot(arm.base(self._tip(hand_pose)), self._target.tolist(), width)

    def steer(self, hand_pose: HandPose) -> None:
        """Command the hand to a pose above its base, which it reaches with the next step."""
        joints = self.arm.joints(self._tip(hand_pose), self._target)
        self.world.drive(joints.tolist(), ((joints - self._target) / TIME_STEP).tolist())
        self._target, self._hand_pose = joints, hand_pose

    def move(self, height: float, seconds: float, limit: float = COLLISION_FORCE) -> float | None:
        """Move the fingertips to a height on a minimum-jerk path, or until a contact force, N.

        A suction cup stays where its ring lies on an object. Returns how far before that height a
        contact stopped the hand, metres; None if none did.
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
        """Back off and stay there, instead of pushing further."""
        height = self.height() + recoil
        for _ in range(2):  # first go there, then stop
            self._raise_to(height)

    def lift(self, height: float, seconds: float, still: Still | None = None) -> bool:
        """Raise the fingertips by a height on a minimum-jerk path; whether they got there.

        `still` tells after every step whether the object lies still in the hand. If so, and if
        nothing can stop the arm, the rest of the path is skipped.
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
        """Stay in place; with `still`, only until the object is held and lies still."""
        for _ in range(round(seconds / TIME_STEP)):
            self.world.step()
            if still and still() and self.carries():
                break

    def go_on(self, seconds: float) -> None:
        """Finish the skipped part of the lift and hold; only for films, as the outcome is known."""
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
                x=hand_pose.x - self._aside * math.cos(hand_pose.angle),
                y=hand_pose.y - self._aside * math.sin(hand_pose.angle),
            )
        return (
            hand_pose._replace(height=hand_pose.height - self._raised)
            if self._raised
            else hand_pose
        )

    def _raise_to(self, height: float) -> None:
        self.steer(self._hand_pose._replace(height=height))
        self.world.step()


class FreeHand(Fingers):
    """A hand that moves along straight lines without turning."""

    def __init__(self, world: World, pose: Floats, width: float) -> None:
        """Open a hand at a pose (`egad.grasps.Grasps.poses`), until the world is reset."""
        super().__init__(world)
        self._rotation = pose[:3, :3]
        self._joints = np.zeros(3)
        robot = world.known_robot
        ahead = self.gripper.kind.span[1] - robot.reach(width)
        tip = pose[:3, 3] - robot.drive.aside(width) * pose[:3, 0] + ahead * pose[:3, 2]
        turn = Rotation.from_matrix(self._rotation).as_quat()
        world.put_robot(Pose(tip, turn), self._joints.tolist(), width)

    def move(self, shift: Floats, speed: float, limit: float = math.inf) -> float:
        """Move by (3,) metres; how far before the end a contact above the limit, N, stopped it.

        A suction cup stays where its ring lies on an object.
        """
        start, length = self._joints, float(np.sqrt((shift**2).sum()))
        along = dot_products(self._rotation.T, shift[None])[:, 0] / length
        for way in minimum_jerk(0.0, length, length / speed):
            joints = start + way * along
            self.world.drive(joints.tolist(), ((joints - self._joints) / TIME_STEP).tolist())
            self._joints = joints
            self.world.step()
            if limit < math.inf and self._force() > limit:
                self._rest()
                return length - way
            if self.arrives():
                self._rest()
                break
        return 0.0

    def moved(self) -> float:
        """How far the hand is from where it was placed, metres."""
        return float(np.linalg.norm(self._joints))

    def _rest(self) -> None:
        """Stay here, instead of pushing further."""
        self._joints = self.world.arm_joints().copy()
        self.world.drive(self._joints.tolist(), [0.0, 0.0, 0.0])

    def touches(self) -> bool:
        """Whether the hand touches anything."""
        return self._force() > 0

    def _force(self) -> float:
        forces = self.world.forces()
        return forces.hand + forces.blocked

    def held(self, *, first: bool = False) -> int | None:
        """Number of the object that is pressed on most, or touched `first`; None if none is."""
        if not self.opening() > MIN_OPENING * self.gripper.opening:
            return None
        numbers = range(len(self.world.models))
        pressed = np.array([self.world.forces(number).hand for number in numbers])
        chosen = np.argmax(pressed > 0 if first else pressed)
        return int(chosen) if pressed[chosen] > 0 else None


def minimum_jerk(start: float, end: float, seconds: float) -> list[float]:
    """Positions, one per time step, from rest to rest (Flash and Hogan 1985)."""
    steps = max(round(seconds / TIME_STEP), 1)
    t = np.arange(1, steps + 1) / steps
    # NumPy's powers differ between processors.
    path: Floats = start + (end - start) * (t * t * t) * (10 - 15 * t + 6 * t**2)
    return [float(place) for place in path]

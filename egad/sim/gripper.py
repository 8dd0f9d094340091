"""A parallel-jaw hand: fingers that close with a force, and what they feel."""

from collections.abc import Callable

import numpy as np
import pybullet
from numpy.typing import NDArray

from egad.grasps import Gripper
from egad.sim.arms import Arm
from egad.sim.hand_urdf import LEFT, PALM, RIGHT
from egad.sim.world import TIME_STEP, World

Floats = NDArray[np.float64]

CLOSING_SPEED = 0.1  # m/s, each finger
CLOSING_TIME = 1.0
STALLED_SPEED = 0.0005
STALLED_STEPS = 24
# A Panda stops at about this contact force; lighter touches only push the object aside.
COLLISION_FORCE = 20.0
SAGGING = 0.02  # metres that a hand may hang too low and still count as lifted
# The part of the time of a minimum-jerk path after which it speeds up most: when it is lifted, the
# object never bears more later on.
HEAVIEST = (3 - 3**0.5) / 6
# The gear must be stronger than the fingers, or an object off the middle holds one of them up.
GEAR_STRENGTH = 10
Still = Callable[[], bool]


class Hand:
    """Palm and two fingers that move as mirror images, carried by an axis or an arm.

    The fingers are driven by a constant force. A gear couples them: with equal and opposite forces
    alone they would drift sideways together.

    Attributes:
        number: Number of the body in the engine.
        fingers: Numbers of the links, left and right.
        path_left: Heights that `lift` left out.
    """

    def __init__(self, world: World, gripper: Gripper, carrier: Arm, width: float) -> None:
        """Open a hand that hangs in a world.

        Args:
            world: The world; the hand is gone when it is reset.
            gripper: Force and pads.
            carrier: What carries it.
            width: Distance of the finger pads, metres.
        """
        self.world = world
        self.gripper = gripper
        self.number = carrier.number
        self.path_left: list[float] = []
        self._carrier = carrier
        joints = range(world.client.getNumJoints(self.number))
        names = [world.client.getJointInfo(self.number, joint)[12].decode() for joint in joints]
        self.fingers = (names.index(LEFT), names.index(RIGHT))
        self._set_up((names.index(PALM), *self.fingers), width)

    def move(self, height: float, seconds: float) -> bool:
        """Move the fingertips to a height on a minimum-jerk path; stop at once at a collision.

        Returns:
            Whether it got there without a contact force of more than `COLLISION_FORCE`.
        """
        for target in _minimum_jerk(self._carrier.height(), height, seconds):
            self._carrier.drive(target)
            self.world.step()
            if self._pushes() > COLLISION_FORCE:
                return False
        return True

    def lift(self, height: float, seconds: float, still: Still | None = None) -> bool:
        """Raise the fingertips by a height on a minimum-jerk path.

        Args:
            height: Metres.
            seconds: How long it takes.
            still: Asked after every step whether the object lies still in the hand. If so, and if
                nothing can stop the carrier, the rest of the path is left out.

        Returns:
            Whether they got there: an arm has its reach, and its strength.
        """
        start = self._carrier.height()
        path = _minimum_jerk(start, start + height, seconds)
        for number, target in enumerate(path, 1):
            self._carrier.drive(target)
            self.world.step()
            if still and still() and self._carrier.unstoppable and self.carries():
                self.path_left = path[number:]
                return True
        return self._carrier.height() > start + height - SAGGING

    def hold(self, seconds: float, still: Still | None = None) -> None:
        """Stay there; only until the object is held and lies still, if this can be asked."""
        for _ in range(round(seconds / TIME_STEP)):
            self.world.step()
            if still and still() and self.carries():
                break

    def go_on(self, seconds: float) -> None:
        """Lift as far as was left out, and stay there: only for films, the outcome is known."""
        for target in self.path_left:
            self._carrier.drive(target)
            self.world.step()
        self.hold(seconds)

    def close(self) -> bool:
        """Close the fingers until they stall, and keep pressing with the gripper's force.

        Returns:
            Whether both of them pressed on the object at some time.
        """
        for finger in self.fingers:
            self.world.client.setJointMotorControl2(
                self.number,
                finger,
                pybullet.VELOCITY_CONTROL,
                targetVelocity=-CLOSING_SPEED,
                force=self.gripper.force,
            )
        still, touched = 0, False
        for _ in range(round(CLOSING_TIME / TIME_STEP)):
            self.world.step()
            touched = touched or self.pinches()
            still = still + 1 if self._finger_speed() < STALLED_SPEED else 0
            if still == STALLED_STEPS:
                break
        return touched

    def pinches(self) -> bool:
        """Whether both fingers press on the object."""
        world = self.world
        return all(world.force(self.number, world.object, finger) > 0 for finger in self.fingers)

    def carries(self) -> bool:
        """Whether the object touches the hand and not the table."""
        world = self.world
        on_table = world.force(world.table, world.object) > 0
        return world.force(self.number, world.object) > 0 and not on_table

    def height(self) -> float:
        """Of the fingertips above the table, metres."""
        return self._carrier.height()

    def opening(self) -> float:
        """Distance of the finger pads, metres."""
        states = self.world.client.getJointStates(self.number, self.fingers)
        return float(sum(state[0] for state in states))

    def _pushes(self) -> float:
        world = self.world
        return world.force(self.number, world.object) + world.force(self.number, world.table)

    def _finger_speed(self) -> float:
        states = self.world.client.getJointStates(self.number, self.fingers)
        return float(max(abs(state[1]) for state in states))

    def _set_up(self, links: tuple[int, ...], width: float) -> None:
        """Friction of palm and fingers, and the fingers held where they are."""
        client, gripper = self.world.client, self.gripper
        friction, radius = gripper.pad
        for link in links:
            # A soft pad resists twisting even where a round object touches it in one point: as a
            # pressed disc. A length; the engine multiplies it by the force.
            spinning = 2 / 3 * friction * radius
            client.changeDynamics(
                self.number, link, lateralFriction=friction, spinningFriction=spinning
            )
        for finger in self.fingers:
            client.resetJointState(self.number, finger, width / 2, 0)
            client.setJointMotorControl2(
                self.number, finger, pybullet.POSITION_CONTROL, width / 2, force=gripper.force
            )
        left, right = self.fingers
        gear = client.createConstraint(
            self.number,
            left,
            self.number,
            right,
            pybullet.JOINT_GEAR,
            (1, 0, 0),
            (0, 0, 0),
            (0, 0, 0),
        )
        client.changeConstraint(gear, gearRatio=-1, maxForce=GEAR_STRENGTH * gripper.force)


def _minimum_jerk(start: float, end: float, seconds: float) -> list[float]:
    """Positions, one a time step, from rest to rest (Flash and Hogan 1985)."""
    steps = max(round(seconds / TIME_STEP), 1)
    t = np.arange(1, steps + 1) / steps
    path: Floats = start + (end - start) * t**3 * (10 - 15 * t + 6 * t**2)
    return [float(place) for place in path]

"""A parallel-jaw hand on a vertical axis."""

from typing import NamedTuple

import numpy as np
import pybullet
from numpy.typing import NDArray

from egad.settings import Gripper
from egad.trials.world import TIME_STEP, World

Floats = NDArray[np.float64]

PALM, LEFT, RIGHT = range(3)  # links; each has the joint that carries it
FINGERS = (LEFT, RIGHT)
PALM_MASS = 0.6
FINGER_MASS = 0.1
# A soft pad resists twisting even where a round object touches it in one point: as a pressed disc
# of 3 mm radius, 2/3 * friction * radius. A length; the engine multiplies it by the force.
PAD_RADIUS = 0.003
AXIS_FORCE = 500.0  # the arm is much stronger than the fingers
POSITION_GAIN = 0.3  # of an error is made good in one step
CLOSING_SPEED = 0.1  # m/s, each finger
CLOSING_TIME = 1.0
STALLED_SPEED = 0.0005
STALLED_STEPS = 24
# A Panda stops at about this contact force; lighter touches only push the object aside.
COLLISION_FORCE = 20.0


class Stance(NamedTuple):
    """Where the hand is: x, y and height of the point between the fingertips, and its turn.

    Attributes:
        x: Metres.
        y: Metres.
        height: Metres above the table.
        angle: Of the closing axis about the vertical, radians.
    """

    x: float
    y: float
    height: float
    angle: float


class Hand:
    """Palm and two fingers, boxes of the gripper's sizes; the fingers move as mirror images.

    The vertical axis is driven to positions, the fingers by a constant force. A gear couples the
    fingers: with equal and opposite forces alone they would drift sideways together.
    """

    def __init__(self, world: World, gripper: Gripper, stance: Stance, width: float) -> None:
        """Add an open hand to a world.

        Args:
            world: The world; the hand is gone when it is reset.
            gripper: Sizes, force and friction.
            stance: Where it starts.
            width: Distance of the finger pads, metres.
        """
        self.world = world
        self.gripper = gripper
        self.number = self._build(stance)
        self._prepare(stance.height, width)

    def move(self, height: float, seconds: float) -> bool:
        """Move the fingertips to a height on a minimum-jerk path; stop at once at a collision.

        Returns:
            Whether it got there without a contact force of more than `COLLISION_FORCE`.
        """
        start = self._position(PALM)
        for target, speed in _minimum_jerk(start, height, seconds):
            self._drive(target, speed)
            self.world.step()
            if self._pushes() > COLLISION_FORCE:
                return False
        return True

    def lift(self, height: float, seconds: float) -> None:
        """Raise the fingertips by a height on a minimum-jerk path."""
        start = self._position(PALM)
        for target, speed in _minimum_jerk(start, start + height, seconds):
            self._drive(target, speed)
            self.world.step()

    def close(self) -> None:
        """Close the fingers until they stall, and keep pressing with the gripper's force."""
        for finger in FINGERS:
            self.world.client.setJointMotorControl2(
                self.number,
                finger,
                pybullet.VELOCITY_CONTROL,
                targetVelocity=-CLOSING_SPEED,
                force=self.gripper.force,
            )
        still = 0
        for _ in range(round(CLOSING_TIME / TIME_STEP)):
            self.world.step()
            still = still + 1 if self._finger_speed() < STALLED_SPEED else 0
            if still == STALLED_STEPS:
                break

    def pinches(self) -> bool:
        """Whether both fingers press on the object."""
        world = self.world
        return all(world.force(self.number, world.object, finger) > 0 for finger in FINGERS)

    def carries(self) -> bool:
        """Whether the object touches the hand and not the table."""
        world = self.world
        on_table = world.force(world.table, world.object) > 0
        return world.force(self.number, world.object) > 0 and not on_table

    def opening(self) -> float:
        """Distance of the finger pads, metres."""
        return self._position(LEFT) + self._position(RIGHT)

    def _pushes(self) -> float:
        world = self.world
        return world.force(self.number, world.object) + world.force(self.number, world.table)

    def _drive(self, height: float, speed: float) -> None:
        self.world.client.setJointMotorControl2(
            self.number,
            PALM,
            pybullet.POSITION_CONTROL,
            targetPosition=height,
            targetVelocity=speed,
            positionGain=POSITION_GAIN,
            force=AXIS_FORCE,
        )

    def _position(self, joint: int) -> float:
        return float(self.world.client.getJointState(self.number, joint)[0])

    def _finger_speed(self) -> float:
        states = self.world.client.getJointStates(self.number, FINGERS)
        return float(max(abs(state[1]) for state in states))

    def _build(self, stance: Stance) -> int:
        """Three prismatic joints. With all at 0 the closed fingertips stand on the table."""
        client, gripper = self.world.client, self.gripper
        finger = np.array([gripper.finger_thickness, gripper.finger_width, gripper.finger_length])
        palm = np.array(gripper.palm)
        sizes = [palm, finger, finger]
        below = -(palm[2] + finger[2]) / 2
        shapes = [
            client.createCollisionShape(pybullet.GEOM_BOX, halfExtents=(size / 2).tolist())
            for size in sizes
        ]
        number: int = client.createMultiBody(
            basePosition=(stance.x, stance.y, 0),
            baseOrientation=client.getQuaternionFromEuler((0, 0, stance.angle)),
            linkMasses=[PALM_MASS, FINGER_MASS, FINGER_MASS],
            linkCollisionShapeIndices=shapes,
            linkVisualShapeIndices=[-1] * 3,
            linkPositions=[
                (0, 0, finger[2] + palm[2] / 2),
                (finger[0] / 2, 0, below),
                (-finger[0] / 2, 0, below),
            ],
            linkOrientations=[(0, 0, 0, 1)] * 3,
            linkInertialFramePositions=[(0, 0, 0)] * 3,
            linkInertialFrameOrientations=[(0, 0, 0, 1)] * 3,
            linkParentIndices=[0, PALM + 1, PALM + 1],
            linkJointTypes=[pybullet.JOINT_PRISMATIC] * 3,
            linkJointAxis=[(0, 0, 1), (1, 0, 0), (-1, 0, 0)],
        )
        return number

    def _prepare(self, height: float, width: float) -> None:
        """Set joints, friction and limits, and hold the hand where it is."""
        client, gripper = self.world.client, self.gripper
        for link, position in ((PALM, height), (LEFT, width / 2), (RIGHT, width / 2)):
            client.resetJointState(self.number, link, position, 0)
            client.changeDynamics(
                self.number,
                link,
                lateralFriction=gripper.friction,
                spinningFriction=2 / 3 * gripper.friction * PAD_RADIUS,
            )
        for finger in FINGERS:
            client.changeDynamics(
                self.number, finger, jointLowerLimit=0.0, jointUpperLimit=gripper.opening / 2
            )
            client.setJointMotorControl2(
                self.number, finger, pybullet.POSITION_CONTROL, width / 2, force=gripper.force
            )
        self._drive(height, 0.0)
        self._couple()

    def _couple(self) -> None:
        client = self.world.client
        gear = client.createConstraint(
            self.number,
            LEFT,
            self.number,
            RIGHT,
            pybullet.JOINT_GEAR,
            (1, 0, 0),
            (0, 0, 0),
            (0, 0, 0),
        )
        client.changeConstraint(gear, gearRatio=-1, maxForce=10 * self.gripper.force)


def _minimum_jerk(start: float, end: float, seconds: float) -> list[tuple[float, float]]:
    """Positions and speeds, one a time step, from rest to rest (Flash and Hogan 1985)."""
    steps = max(round(seconds / TIME_STEP), 1)
    t = np.arange(1, steps + 1) / steps
    path: Floats = start + (end - start) * t**3 * (10 - 15 * t + 6 * t**2)
    speed: Floats = (end - start) / (steps * TIME_STEP) * 30 * t**2 * (1 - t) ** 2
    return list(zip(path.tolist(), speed.tolist(), strict=True))

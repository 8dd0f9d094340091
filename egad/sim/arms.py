"""What carries the hand and moves it up and down: a vertical axis, or a Franka Panda arm."""

from typing import NamedTuple, Protocol

import numpy as np
import pybullet
from numpy.typing import NDArray

from egad.grasps import Gripper
from egad.sim.hand_urdf import TIP, on_axis, on_panda
from egad.sim.world import TIME_STEP, World

Floats = NDArray[np.float64]

AXIS_FORCE = 500.0  # the arm is much stronger than the fingers
POSITION_GAIN = 0.3  # of an error is made good in one step
PANDA_BASE = (-0.5, 0.0, 0.0)  # so that the middle of the table is in front of it
PANDA_READY = (0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785)  # Franka's own name and numbers
PANDA_TORQUES = (87.0, 87.0, 87.0, 87.0, 12.0, 12.0, 12.0)  # N m, of Franka's data sheet
ARM = len(PANDA_READY)
APPROACHES = 50
CLOSE = 1e-5  # metres
REACHABLE = 1e-3


class UnreachableError(Exception):
    """The arm cannot bring the hand there."""


class HandPose(NamedTuple):
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


class Arm(Protocol):
    """A body in the engine that ends in the hand of `hand_urdf`.

    Attributes:
        number: Of the body.
        unstoppable: Whether it gets to any height, whatever it carries.
    """

    number: int
    unstoppable: bool

    def drive(self, height: float) -> None:
        """Steer the fingertips to a height, to be there after the next step."""

    def height(self) -> float:
        """Of the fingertips above the table, metres."""


class Axis:
    """A vertical axis with position control; nothing bends."""

    unstoppable = True

    def __init__(self, world: World, gripper: Gripper, stance: HandPose) -> None:
        """Add it to a world, with the hand where it is wanted."""
        self._client = world.client
        turn = self._client.getQuaternionFromEuler((0, 0, stance.angle))
        self.number = world.add_robot(on_axis(gripper), (stance.x, stance.y, 0), turn)
        self._client.resetJointState(self.number, 0, stance.height, 0)
        self._target = stance.height
        self.drive(stance.height)

    def drive(self, height: float) -> None:
        """Steer the fingertips to a height."""
        self._client.setJointMotorControl2(
            self.number,
            0,
            pybullet.POSITION_CONTROL,
            targetPosition=height,
            targetVelocity=(height - self._target) / TIME_STEP,
            positionGain=POSITION_GAIN,
            force=AXIS_FORCE,
        )
        self._target = height

    def height(self) -> float:
        """Of the fingertips above the table."""
        return float(self._client.getJointState(self.number, 0)[0])


class Panda:
    """A Franka Panda arm, its joints under position control with the torques of its data sheet.

    The hand is that of the gripper table at the flange, not Franka's: a gripper is the same with
    either carrier.
    """

    unstoppable = False

    def __init__(self, world: World, gripper: Gripper, stance: HandPose) -> None:
        """Add it to a world, with the hand where it is wanted.

        Raises:
            UnreachableError: The hand cannot get there.
        """
        self._client, self._stance = world.client, stance
        self.number = world.add_robot(on_panda(gripper), PANDA_BASE, (0, 0, 0, 1))
        joints = range(self._client.getNumJoints(self.number))
        names = [self._client.getJointInfo(self.number, joint)[12].decode() for joint in joints]
        self._tip = names.index(TIP)
        # The hand is its own mirror image: the turn that needs least of the last joint.
        angle = -((-stance.angle) % np.pi)
        self._down = self._client.getQuaternionFromEuler((np.pi, 0, angle))
        self._joints = self._settled(stance.height)
        self.drive(stance.height)

    def drive(self, height: float) -> None:
        """Steer the fingertips to a height."""
        joints = self._solved(height)
        self._client.setJointMotorControlArray(
            self.number,
            list(range(ARM)),
            pybullet.POSITION_CONTROL,
            targetPositions=joints.tolist(),
            targetVelocities=((joints - self._joints) / TIME_STEP).tolist(),
            positionGains=[POSITION_GAIN] * ARM,
            forces=list(PANDA_TORQUES),
        )
        self._joints = joints

    def height(self) -> float:
        """Of the fingertips above the table."""
        return float(self._place()[2])

    def _place(self) -> Floats:
        state = self._client.getLinkState(self.number, self._tip, computeForwardKinematics=1)
        return np.array(state[4])

    def _solved(self, height: float) -> Floats:
        """Joint angles for a height, near those of now."""
        angles = self._client.calculateInverseKinematics(
            self.number,
            self._tip,
            (self._stance.x, self._stance.y, height),
            self._down,
            maxNumIterations=20,
            residualThreshold=CLOSE,
        )
        return np.array(angles[:ARM])

    def _settled(self, height: float) -> Floats:
        """Set the joints so that the hand is at a height, starting from the ready position."""
        wanted = np.array([self._stance.x, self._stance.y, height])
        joints = np.array(PANDA_READY)
        for _ in range(APPROACHES):
            for joint, angle in enumerate(joints.tolist()):
                self._client.resetJointState(self.number, joint, angle, 0)
            if np.abs(self._place() - wanted).max() < CLOSE:
                break
            joints = self._solved(height)
        if np.abs(self._place() - wanted).max() > REACHABLE:
            raise UnreachableError(f"the arm cannot bring the hand to {wanted}")
        return joints


ARMS: dict[str, type[Axis] | type[Panda]] = {"axis": Axis, "panda": Panda}

"""Arms that carry the hand and move it up and down: a vertical axis, or a Franka Panda arm."""

from abc import ABC, abstractmethod
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation
from typing_extensions import override

from egad._util.arrays import Floats
from egad.grippers import Gripper
from egad.sim.robot import Robot
from egad.sim.robots import on_axis, on_panda
from egad.sim.world import Pose

UPRIGHT = np.array([0.0, 0.0, 0.0, 1.0])
PANDA_BASE = np.array([-0.5, 0.0, 0.0])  # so that the middle of the table is in front of it
PANDA_READY = (0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785)  # Franka's own name and numbers
ITERATIONS = 100
CLOSE = 1e-6  # metres and radians
REACHABLE = 1e-3
DAMPING = 1e-3  # of steps near a singular pose
MAX_STEP = 0.2  # radians


class UnreachableError(Exception):
    """The arm cannot bring the hand to a pose."""


class HandPose(NamedTuple):
    """Pose of the hand: the point between the fingertips, metres, and the closing axis, radians."""

    x: float
    y: float
    height: float
    angle: float


class Arm(ABC):
    """How a robot brings its hand, pointing down, to a pose; unstoppable: whatever it carries."""

    robot: Robot
    unstoppable: bool

    @abstractmethod
    def base(self, hand_pose: HandPose) -> Pose:
        """Where the robot stands to bring its hand to a pose."""

    @abstractmethod
    def joints(self, hand_pose: HandPose, near: Floats | None = None) -> Floats:
        """Joint positions that bring the hand to a pose, near given ones; or UnreachableError."""

    @abstractmethod
    def height(self, joints: Floats) -> float:
        """Height of the fingertips above the table, metres."""


class TurningAxis(Arm):
    """A vertical axis above the hand, which can turn; nothing bends."""

    unstoppable = True

    def __init__(self, gripper: Gripper) -> None:
        """Attach a hand."""
        self.robot = on_axis(gripper)

    @override
    def base(self, hand_pose: HandPose) -> Pose:
        return Pose(np.array([hand_pose.x, hand_pose.y, 0.0]), UPRIGHT)

    @override
    def joints(self, hand_pose: HandPose, near: Floats | None = None) -> Floats:
        del near
        return np.array([hand_pose.height, hand_pose.angle])

    @override
    def height(self, joints: Floats) -> float:
        return float(joints[0])


class Panda(Arm):
    """A Franka Panda arm under position control, with its torques and the configured gripper."""

    unstoppable = False

    def __init__(self, gripper: Gripper) -> None:
        """Attach a hand."""
        self.robot = on_panda(gripper)
        limits = {joint.child: joint.limits for joint in self.robot.joints}
        self._limits = np.array([limits[name] for name in self.robot.arm])

    @override
    def base(self, hand_pose: HandPose) -> Pose:
        del hand_pose
        return Pose(PANDA_BASE, UPRIGHT)

    @override
    def joints(self, hand_pose: HandPose, near: Floats | None = None) -> Floats:
        wanted = np.eye(4)
        # Of a hand and its mirror image, take the angle that turns the last joint least.
        angle = -((-hand_pose.angle) % (np.pi if self.robot.drive.mirrored else 2 * np.pi))
        wanted[:3, :3] = Rotation.from_euler("xz", (np.pi, angle)).as_matrix()
        wanted[:3, 3] = np.array([hand_pose.x, hand_pose.y, hand_pose.height]) - PANDA_BASE
        joints = np.array(PANDA_READY) if near is None else near
        # From nearby joints, the error after one step is quadratic; the next step corrects it.
        for _ in range(ITERATIONS if near is None else 1):
            error, jacobian = self._error(joints, wanted)
            if np.abs(error).max() < CLOSE:
                break
            joints = np.clip(joints + _damped(jacobian, error), *self._limits.T)
        if near is None and np.abs(self._error(joints, wanted)[0]).max() > REACHABLE:
            raise UnreachableError(f"the arm cannot bring the hand to {hand_pose}")
        return joints

    @override
    def height(self, joints: Floats) -> float:
        return float(self.robot.tip_poses(joints.tolist())[-1][2, 3])

    def _error(self, joints: Floats, wanted: Floats) -> tuple[Floats, Floats]:
        """The error, as a shift and a rotation vector, (6,), and the Jacobian, (6, 7)."""
        *frames, tip = self.robot.tip_poses(joints.tolist())
        axes, origins = np.moveaxis(np.array(frames)[:, :3, 2:], 2, 0)
        levers = tip[:3, 3] - origins
        turn = wanted[:3, :3] @ tip[:3, :3].T
        # For a small angle, the antisymmetric part of a rotation is its rotation vector.
        skew = (turn.T - turn)[[1, 2, 0], [2, 0, 1]] / 2
        error = np.concatenate([wanted[:3, 3] - tip[:3, 3], skew])
        return error, np.vstack([_cross(axes, levers).T, axes.T])


def _cross(first: Floats, second: Floats) -> Floats:
    """Same as `np.cross` of (n, 3), which takes five times as long for few rows."""
    ahead, behind = [1, 2, 0], [2, 0, 1]
    product: Floats = first[:, ahead] * second[:, behind] - first[:, behind] * second[:, ahead]
    return product


def _damped(jacobian: Floats, error: Floats) -> Floats:
    """A step of damped least squares, (n,), shortened if it is long (Wampler 1986)."""
    square = jacobian @ jacobian.T + DAMPING**2 * np.eye(len(jacobian))
    step: Floats = jacobian.T @ np.linalg.solve(square, error)
    return step * min(1.0, MAX_STEP / max(float(np.abs(step).max()), MAX_STEP))


ARMS: dict[str, type[TurningAxis] | type[Panda]] = {"axis": TurningAxis, "panda": Panda}

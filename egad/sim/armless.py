"""A hand without an arm, which moves along straight lines without turning."""

import math

import numpy as np
from scipy.spatial.transform import Rotation
from typing_extensions import override

from egad._util.arrays import Floats
from egad.grippers import tip_reach
from egad.sim.cup import Cup
from egad.sim.gripper import Fingers, minimum_jerk
from egad.sim.world import TIME_STEP, Pose, World

MIN_OPENING = 0.1  # of the hand's opening; if closed further, the fingers hold nothing (as in VGN)


class FreeHand(Fingers):
    """A hand that moves along straight lines without turning."""

    def __init__(self, world: World, pose: Floats, width: float) -> None:
        """Open a hand at a pose (`egad.grasps.Grasps.poses`), until the world is reset."""
        super().__init__(world)
        self._rotation = pose[:3, :3]
        self._joints = np.zeros(3)
        ahead, tip = tip_reach(self.gripper), pose[:3, 3]
        if world.robot is not None:
            ahead -= world.robot.reach(width)
            tip = tip - world.robot.aside(width) * pose[:3, 0]
        tip = tip + ahead * pose[:3, 2]
        turn = Rotation.from_matrix(self._rotation).as_quat()
        world.put_robot(Pose(tip, turn), self._joints.tolist(), width)

    def move(self, shift: Floats, speed: float, limit: float = math.inf) -> float:
        """Move by (3,) metres on a minimum-jerk path; how far before the end it stopped, metres.

        A suction cup stays where its ring lies on an object. A contact force above the limit, N,
        stops any hand.
        """
        start, length = self._joints, float(np.linalg.norm(shift))
        along = self._rotation.T @ shift / length
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
        """Number of the object that the hand presses on most; None if none, or if it is closed.

        Args:
            first: Whether to return the first object that the hand touches instead.
        """
        if not self.opening() > MIN_OPENING * self.gripper.opening:
            return None
        numbers = range(len(self.world.models))
        pressed = np.array([self.world.forces(number).hand for number in numbers])
        chosen = np.argmax(pressed > 0 if first else pressed)
        return int(chosen) if pressed[chosen] > 0 else None


class FreeCup(Cup, FreeHand):
    """A suction cup that moves along straight lines without turning."""

    @override
    def held(self, *, first: bool = False) -> int | None:
        del first
        return self.world.attached

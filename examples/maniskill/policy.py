"""A scripted policy for PickSingleEGAD-v1: it carries out labelled grasps from above."""

from collections.abc import Iterator

import gymnasium as gym
import numpy as np
import sapien
from mani_skill.agents.robots import Panda
from numpy.typing import NDArray
from pick_single_egad import PickSingleEGADEnv

import egad

Floats = NDArray[np.float64]

MAX_TILT = np.radians(60)  # of the approach against the vertical
CLEARANCE = 0.002  # metres between the hand and the table
MAX_RETREAT = 0.006  # metres that a grasp is moved back along its approach to clear the table
PREGRASP = 0.1  # metres back along the approach
LIFT = 0.1  # metres
TRIED = 20  # grasps of which the arm tries to reach one
OPEN, CLOSED = 1.0, -1.0  # actions of the fingers
# Corners of ManiSkill's Panda hand in the frame of its TCP, y along the closing axis, metres: the
# tips of the open fingers, and the palm.
HAND = np.array(
    [[x, y, 0.009] for x in (-0.0105, 0.0105) for y in (-0.055, 0.055)]
    + [[x, y, -0.045] for x in (-0.032, 0.032) for y in (-0.103, 0.103)]
)


def tcp_poses(grasps: egad.Grasps, object_pose: Floats) -> Floats:
    """Poses of the Panda's TCP at the grasps that it can reach from above, best first.

    Left out are grasps where the labels report a collision of the hand with the object, where the
    approach is tilted by more than 60 degrees, and where the hand cannot clear the table if it
    moves back by at most 6 mm. The order is that of the robust quality. The hand is symmetric, so
    each grasp is listed twice, turned by 180 degrees about the approach.

    Args:
        grasps: Of the object.
        object_pose: (4, 4) pose of the object on the table, whose top is z = 0.

    Returns:
        (n, 4, 4) in the world.
    """
    usable = grasps[grasps.collision_free & (grasps.quality > 0)].sorted_by("robust_quality")
    hand = object_pose @ usable.poses
    x, y, z = (hand[:, :3, i] for i in range(3))
    poses = hand.copy()
    poses[:, :3, 0], poses[:, :3, 1] = -y, x  # the Panda's fingers close along y
    down = -z[:, 2]
    lowest = (HAND @ poses[:, :3, :3].transpose(0, 2, 1))[:, :, 2].min(axis=1) + poses[:, 2, 3]
    steep = down >= np.cos(MAX_TILT)
    retreat = np.maximum(CLEARANCE - lowest, 0) / np.where(steep, down, 1)
    poses[:, :3, 3] -= retreat[:, None] * z
    poses = poses[steep & (retreat <= MAX_RETREAT)]
    return np.repeat(poses, 2, axis=0) * _flips(len(poses))


def _flips(count: int) -> Floats:
    flip = np.ones((2, 4, 4))
    flip[1, :3, :2] = -1
    return np.tile(flip, (count, 1, 1))


class Arm:
    """Inverse kinematics of the Panda, with the solver that comes with SAPIEN."""

    def __init__(self, agent: Panda) -> None:
        """Build the kinematic model.

        Args:
            agent: Of an environment on the CPU.
        """
        self.model = agent.robot.create_pinocchio_model()
        self.link = [link.name for link in agent.robot.links].index(agent.tcp.name)
        self.base = agent.robot.pose.sp.inv()
        self.limits = agent.robot.get_qlimits()[0].numpy()
        self.moving = np.array([1] * 7 + [0] * 2)

    def reach(self, pose: Floats, start: Floats) -> Floats | None:
        """Joint positions that put the TCP at a pose, or None if there are none.

        Args:
            pose: (4, 4) in the world.
            start: (9,) joint positions that the search starts from.
        """
        joints, found, _ = self.model.compute_inverse_kinematics(
            self.link, self.base * sapien.Pose(pose), start, self.moving, max_iterations=200
        )
        inside = (joints >= self.limits[:, 0]) & (joints <= self.limits[:, 1])
        return joints if found and inside[:7].all() else None

    def line(self, first: Floats, last: Floats, start: Floats, steps: int) -> list[Floats] | None:
        """Joint positions along a straight line of the TCP, which keeps its orientation.

        Args:
            first: (4, 4) pose at the beginning, which is left out.
            last: (4, 4) pose at the end.
            start: (9,) joint positions at the beginning.
            steps: How many positions.
        """
        path = []
        for part in np.arange(1, steps + 1) / steps:
            pose = last.copy()
            pose[:3, 3] = (1 - part) * first[:3, 3] + part * last[:3, 3]
            joints = self.reach(pose, path[-1] if path else start)
            if joints is None:
                return None
            path.append(joints)
        return path


def moved(pose: Floats, by: Floats) -> Floats:
    """A pose, moved by (3,) metres in the world."""
    result = pose.copy()
    result[:3, 3] += by
    return result


class LiftPolicy:
    """Carries out one labelled grasp in an environment that was just reset.

    The control mode of the environment is `pd_joint_pos`.
    """

    def __init__(self, env: gym.Env, grasps: egad.Grasps) -> None:
        """Get ready.

        Args:
            env: `PickSingleEGAD-v1` with a single environment on the CPU.
            grasps: Of its object.
        """
        self.env, self.grasps = env, grasps
        self.base: PickSingleEGADEnv = env.unwrapped
        self.arm = Arm(self.base.agent)
        self.joints: Floats = self.base.agent.robot.get_qpos()[0].numpy().astype(np.float64)
        self.info: dict = {}

    def run(self) -> str:
        """Grasp the object, lift it and hold it at the goal.

        Returns:
            `success`; `no grasp`: no labelled grasp is possible from above; `unreachable`: the arm
            cannot reach one; `missed`: the closed fingers do not hold the object; `dropped`: they
            lost it later; `off goal`: it is held elsewhere.
        """
        object_pose = self.base.obj.pose.to_transformation_matrix()[0].numpy().astype(np.float64)
        poses = tcp_poses(self.grasps, object_pose)
        if len(poses) == 0:
            return "no grasp"
        plan = next(self._plans(poses[: 2 * TRIED]), None)
        if plan is None:
            return "unreachable"
        grasp, way_there, way_in, way_up = plan
        self._follow([*way_there, *way_in, *[way_in[-1]] * 4], OPEN)
        self._follow([way_in[-1]] * 12, CLOSED)
        if not self._holds():
            return "missed"
        self._follow(way_up, CLOSED)
        self._carry(moved(grasp, np.array([0, 0, LIFT])))
        if bool(self.info["success"]):
            return "success"
        return "off goal" if self._holds() else "dropped"

    def _plans(
        self, poses: Floats
    ) -> Iterator[tuple[Floats, list[Floats], list[Floats], list[Floats]]]:
        """Grasps that can be reached, with the ways to the pregrasp, to the grasp and up."""
        for pose in poses:
            before = moved(pose, -PREGRASP * pose[:3, 2])
            joints = self.arm.reach(before, self.joints)
            if joints is None:
                continue
            way_in = self.arm.line(before, pose, joints, 15)
            if way_in is None:
                continue
            way_up = self.arm.line(pose, moved(pose, np.array([0, 0, LIFT])), way_in[-1], 15)
            if way_up is not None:
                parts = np.linspace(0, 1, 26)[1:, None]
                yield pose, list(self.joints + parts * (joints - self.joints)), way_in, way_up

    def _carry(self, pose: Floats) -> None:
        """Move the center of the object to the goal, and correct what remains; then stand still."""
        for steps in (25, 8, 8):
            shift = self.base.evaluate()["center_to_goal"][0].numpy().astype(np.float64)
            way = self.arm.line(pose, moved(pose, shift), self.joints, steps)
            if way is None:
                return
            pose = moved(pose, shift)
            self._follow([*way, *[way[-1]] * 6], CLOSED)

    def _follow(self, way: list[Floats], fingers: float) -> None:
        for joints in way:
            action = np.append(joints[:7], fingers).astype(np.float32)
            *_, self.info = self.env.step(action)
            self.joints = joints

    def _holds(self) -> bool:
        return bool(self.base.agent.is_grasping(self.base.obj))

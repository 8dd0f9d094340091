"""A scripted policy for PickSingleEGAD-v1: it carries out labelled grasps from above."""

from collections.abc import Iterator
from itertools import islice

import gymnasium as gym
import numpy as np
import sapien
import torch
import trimesh
from egad_objects import SURFACE
from mani_skill.agents.robots import Panda
from numpy.typing import NDArray
from pick_single_egad import PickSingleEGADEnv

import egad

Floats = NDArray[np.float64]
Way = list[Floats]  # (9,) joint positions, one for each step

MAX_TILT = np.radians(75)  # of the approach against the vertical
CLEARANCE = 0.002  # metres between the hand and the table
MAX_RETREAT = 0.006  # metres that a grasp is moved back along its approach to clear the table
PREGRASP = 0.1  # metres back along the approach
LIFT = np.array([0, 0, 0.1])  # metres
TRIED = 20  # grasps of which the arm tries to reach one
SETTLE = 10  # steps until an object that was put on the table is at rest
POINTS = 2000  # points on the object that stand for it when the hand is tested for collisions
OPEN, CLOSED = 1.0, -1.0  # actions of the fingers
# ManiSkill's Panda hand in the frame of its TCP, whose y is the closing axis and z the approach,
# metres. Fingers: half width, the inner and outer side when they are open, and the tip.
FINGER_X, INSIDE, OUTSIDE, TIP = 0.011, 0.039, 0.056, 0.0095
PALM_X, PALM_Y, PALM_Z = 0.032, 0.104, -0.037  # half sides, and where it begins
TURNS = np.eye(4), np.diag([-1.0, -1.0, 1.0, 1.0])
CORNERS = np.array(
    [[x, y, TIP] for x in (-FINGER_X, FINGER_X) for y in (-OUTSIDE, OUTSIDE)]
    + [[x, y, PALM_Z] for x in (-PALM_X, PALM_X) for y in (-PALM_Y, PALM_Y)]
)


def tcp_poses(grasps: egad.Grasps, object_pose: Floats, surface: Floats) -> list[Floats]:
    """Poses of the Panda's TCP at the grasps that are possible from above, best first.

    The labels give the contacts and their order, by robust quality. The approach is the steepest
    around the closing axis, in steps of 15 degrees, that is tilted by at most 75 degrees and at
    which the open hand clears the object on its whole way in, and the table if it moves back by at
    most 6 mm. At most `TRIED` (4, 4) poses in the world are returned.

    Args:
        grasps: Of the object.
        object_pose: (4, 4) pose of the object on the table, whose top is z = 0.
        surface: (n, 3) points of its surface, in its own frame.
    """
    points = surface @ object_pose[:3, :3].T + object_pose[:3, 3]
    hands = object_pose @ grasps.sorted_by("robust_quality").poses
    first = (next((p for p in _approaches(hand) if _clear(p, points)), None) for hand in hands)
    return list(islice((pose for pose in first if pose is not None), TRIED))


def _approaches(hand: Floats) -> Iterator[Floats]:
    """TCP poses around the closing axis of a hand that clear the table, the steepest first."""
    closing, across, approach = hand[:3, :3].T
    for angle in sorted(
        np.radians(range(0, 360, 15)),
        key=lambda angle: np.cos(angle) * approach[2] + np.sin(angle) * across[2],
    ):
        forward = np.cos(angle) * approach + np.sin(angle) * across
        if -forward[2] < np.cos(MAX_TILT):
            return
        pose = np.eye(4)
        pose[:3, :3] = np.column_stack([np.cross(closing, forward), closing, forward])
        lowest = (CORNERS @ pose[:3, :3].T)[:, 2].min() + hand[2, 3]
        retreat = max(CLEARANCE - lowest, 0.0) / -forward[2]
        pose[:3, 3] = hand[:3, 3] - retreat * forward
        if retreat <= MAX_RETREAT:
            yield pose


def _clear(pose: Floats, points: Floats) -> bool:
    """Whether the open hand touches none of the (n, 3) points on its straight way to a pose."""
    x, y, z = ((points - pose[:3, 3]) @ pose[:3, :3]).T
    x, y = np.abs(x), np.abs(y)
    finger = (x < FINGER_X) & (y > INSIDE) & (y < OUTSIDE) & (z < TIP)
    palm = (x < PALM_X) & (y < PALM_Y) & (z < PALM_Z)
    return not bool((finger | palm).any())


class Arm:
    """Inverse kinematics of the Panda, with the solver that comes with SAPIEN."""

    def __init__(self, agent: Panda) -> None:
        """Build the kinematic model of a robot that is simulated on the CPU."""
        self.model = agent.robot.create_pinocchio_model()
        self.link = [link.name for link in agent.robot.links].index(agent.tcp.name)
        self.base = agent.robot.pose.sp.inv()
        self.limits = agent.robot.get_qlimits()[0].numpy()
        self.moving = np.array([1] * 7 + [0] * 2)

    def reach(self, pose: Floats, start: Floats) -> Floats | None:
        """The (9,) joint positions near others that put the TCP at a pose, or None."""
        joints, found, _ = self.model.compute_inverse_kinematics(
            self.link, self.base * sapien.Pose(pose), start, self.moving, max_iterations=200
        )
        inside = (joints >= self.limits[:, 0]) & (joints <= self.limits[:, 1])
        return joints if found and inside[:7].all() else None

    def line(self, first: Floats, last: Floats, start: Floats, steps: int) -> Way | None:
        """Joint positions on a straight line of the TCP between poses; without the first."""
        path: Way = []
        for part in np.arange(1, steps + 1) / steps:
            pose = moved(last, (1 - part) * (first - last)[:3, 3])
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


def _array(values: torch.Tensor) -> Floats:
    """The values of the only environment."""
    return values[0].numpy().astype(np.float64)


class LiftPolicy:
    """Carries out one labelled grasp in an environment that was just reset."""

    def __init__(self, env: gym.Env, grasps: egad.Grasps) -> None:
        """Take a single environment on the CPU with `pd_joint_pos`, and grasps of its object."""
        self.env, self.grasps = env, grasps
        self.base: PickSingleEGADEnv = env.unwrapped
        self.arm = Arm(self.base.agent)
        self.joints = _array(self.base.agent.robot.get_qpos())
        self.info: dict = {}

    def run(self) -> str:
        """Grasp the object, lift it and hold it at the goal.

        Returns:
            `success`; `no grasp`: no labelled grasp is possible from above; `unreachable`: the arm
            cannot reach one; `missed`: the closed fingers do not hold the object; `dropped`: they
            lost it later; `off goal`: it is held elsewhere.
        """
        self._follow([self.joints] * SETTLE, OPEN)
        mesh = trimesh.load_mesh(self.base.objects[0].folder / SURFACE)
        surface = trimesh.sample.sample_surface(mesh, POINTS, seed=0)[0]
        object_pose = _array(self.base.obj.pose.to_transformation_matrix())
        poses = tcp_poses(self.grasps, object_pose, surface)
        if not poses:
            return "no grasp"
        plan = next(self._plans(poses), None)
        if plan is None:
            return "unreachable"
        grasp, way_there, way_in, way_up = plan
        self._follow([*way_there, *way_in, *[way_in[-1]] * 4], OPEN)
        self._follow([way_in[-1]] * 12, CLOSED)
        if not self._holds():
            return "missed"
        self._follow(way_up, CLOSED)
        self._carry(moved(grasp, LIFT))
        if bool(self.info["success"]):
            return "success"
        return "off goal" if self._holds() else "dropped"

    def _plans(self, poses: list[Floats]) -> Iterator[tuple[Floats, Way, Way, Way]]:
        """Grasps that can be reached, with the ways to the pregrasp, to the grasp and up.

        The hand is symmetric: it may be turned by 180 degrees about the approach.
        """
        for pose in (pose @ turn for pose in poses for turn in TURNS):
            before = moved(pose, -PREGRASP * pose[:3, 2])
            joints = self.arm.reach(before, self.joints)
            way_in = None if joints is None else self.arm.line(before, pose, joints, 15)
            up = moved(pose, LIFT)
            way_up = None if way_in is None else self.arm.line(pose, up, way_in[-1], 15)
            if way_up is not None:
                parts = np.linspace(0, 1, 26)[1:, None]
                yield pose, list(self.joints + parts * (joints - self.joints)), way_in, way_up

    def _carry(self, pose: Floats) -> None:
        """Move the center of the object to the goal, and correct what remains; then stand still."""
        for steps in (25, 8, 8):
            goal = moved(pose, _array(self.base.evaluate()["center_to_goal"]))
            way = self.arm.line(pose, goal, self.joints, steps)
            if way is None:
                return
            pose = goal
            self._follow([*way, *[way[-1]] * 6], CLOSED)

    def _follow(self, way: Way, fingers: float) -> None:
        for joints in way:
            action = np.append(joints[:7], fingers).astype(np.float32)
            *_, self.info = self.env.step(action)
            self.joints = joints

    def _holds(self) -> bool:
        return bool(self.base.agent.is_grasping(self.base.obj))

"""A grasp, as detectors propose it and a hand executes it: straight from above, or as a pose."""

import math
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from egad._util.arrays import Floats
from egad.grasps import are_rigid, hand_poses
from egad.grippers import Gripper
from egad.tables.outcomes import Outcome

MAX_GRASPS = 50  # kept from the candidates of a detector
SEARCH = 0.01  # metres that a suction cup searches beyond where it should meet an object
MIN_DEPTH = 0.005  # metres that the fingertips must reach below the surface that is seen
FULL_DEPTH = 0.02  # metres; nothing is gained by reaching further
RIGID = 1e-3  # largest entry of R^T R - 1; networks answer in single precision
WHERE = "detectors"


@dataclass(frozen=True)
class Grasp:
    """A grasp of a parallel-jaw hand or a suction cup: straight from above, unless it has a pose.

    Attributes:
        center: Where the pads should meet the object: midpoint of the contacts, world frame, m.
            For a cup, where the middle of its ring should.
        angle: Angle of the closing axis about the vertical, from the world's x axis, radians.
        width: How far to open, metres; 0 for a cup.
        depth: How far the fingertips reach below the center, metres. A cup goes at most this far to
            find the object, and stops where its ring lies on it.
        quality: What the detector expects of it; the highest is tried.
        free_pose: (4, 4) from the frame of the hand to the world, if the approach may have any
            direction: the origin is midway between the pads, x is the closing axis, z the approach.
            Center and angle then follow from it; the depth is 0.
    """

    center: tuple[float, float, float]
    angle: float
    width: float
    depth: float
    quality: float
    free_pose: Floats | None = field(default=None, compare=False, kw_only=True)

    @classmethod
    def of_pose(cls, pose: Floats, width: float, quality: float) -> Self:
        """A grasp in any direction; see `free_pose`."""
        (x, y, z), axis = pose[:3, 3].tolist(), pose[:3, 0]
        angle = float(np.arctan2(axis[1], axis[0]))
        return cls((x, y, z), angle, width, 0.0, quality, free_pose=pose)

    @property
    def pose(self) -> Floats:
        """The pose of the hand, (4, 4); ValueError for a grasp from above (use `as_pose`)."""
        if self.free_pose is None:
            raise ValueError("the pose of a grasp from above depends on the gripper")
        return self.free_pose

    @property
    def tip(self) -> float:
        """Height of the fingertips of a grasp from above, metres above the table."""
        return self.center[2] - self.depth

    def as_pose(self, gripper: Gripper) -> "Grasp":
        """The same with its pose: the fingertips end alike, a cup begins at the center."""
        if self.free_pose is not None:
            return self
        axis = np.array([[np.cos(self.angle), np.sin(self.angle), 0.0]])
        kind = gripper.kind
        height = self.tip + kind.span[1] if kind.closes else self.center[2]
        center = np.array([[*self.center[:2], height]])
        pose = hand_poses(center, axis, np.array([[0.0, 0.0, -1.0]]))[0]
        return Grasp.of_pose(pose, self.width, self.quality)

    def from_above(self, gripper: Gripper) -> "Grasp":
        """The grasp straight from above at the same place: the inverse of `as_pose`."""
        if self.free_pose is None:
            return self
        x, y, z = self.center
        depth = 0.0 if gripper.kind.closes else min(SEARCH, z)
        return Grasp((x, y, z - gripper.kind.span[1]), self.angle, self.width, depth, self.quality)

    def moved(self, matrix: NDArray[np.floating[Any]]) -> "Grasp":
        """A grasp with a pose, moved by a transform, (4, 4)."""
        return Grasp.of_pose(matrix @ self.pose, self.width, self.quality)

    def infeasibility(self, gripper: Gripper) -> Outcome | None:
        """Why the hand cannot execute this, as the outcome of an attempt; None if it can.

        not_finite: a number is NaN or infinite; not_rigid: the pose is not a rotation and
        translation; too_wide: the hand would have to open wider than it can, or by less than 0;
        below_table: the middle of the fingertips would be under the table.
        """
        pose, numbers = self.free_pose, (*self.center, self.angle, self.width, self.depth)
        if not all(map(math.isfinite, (*numbers, self.quality))):
            return Outcome.NOT_FINITE
        if pose is not None and not np.isfinite(pose).all():
            return Outcome.NOT_FINITE
        if pose is not None and not are_rigid(pose[None], RIGID).all():
            return Outcome.NOT_RIGID
        if not 0 <= self.width <= gripper.opening:
            return Outcome.TOO_WIDE
        lowest = self.tip if pose is None else pose[2, 3] + gripper.kind.span[1] * pose[2, 2]
        return Outcome.BELOW_TABLE if lowest < 0 else None


class GraspPoses(NamedTuple):
    """Grasps in any direction.

    Attributes:
        poses: (n, 4, 4) from the frame of the hand to the world: the origin is midway between the
            pads, x is the closing axis, z the approach. The origin of a suction cup is in the
            middle of its ring, and x any direction across.
        widths: (n,) how far to open, metres.
        scores: (n,) what the detector expects of them; the highest is tried.
    """

    poses: Floats
    widths: Floats
    scores: Floats


Answer = list[Grasp] | GraspPoses


def poses_of(answer: Any) -> GraspPoses:  # noqa: ANN401 (whatever a detector gives)
    """An answer as arrays: `GraspPoses` or a tuple like it; else TypeError or ValueError."""
    poses, widths, scores = (np.asarray(each, dtype=np.float64) for each in answer)
    count = len(poses)
    if count == 0:
        poses = poses.reshape(0, 4, 4)
    if poses.shape != (count, 4, 4) or widths.shape != (count,) or scores.shape != (count,):
        raise ValueError(
            f"poses, widths and scores must be (n, 4, 4), (n,) and (n,), got {poses.shape}, "
            f"{widths.shape} and {scores.shape}"
        )
    return GraspPoses(poses, widths, scores)


def best_poses(grasps: GraspPoses, count: int = MAX_GRASPS) -> GraspPoses:
    """Those with the highest scores, best first, equals in the order given."""
    order = np.argsort(-grasps.scores, kind="stable")[:count]
    return GraspPoses(grasps.poses[order], grasps.widths[order], grasps.scores[order])


def depth_weight(penetration: Floats) -> Floats:
    """Factor of a quality for how far the fingertips get below the surface seen, metres: 0 to 1."""
    share: Floats = np.clip(penetration / FULL_DEPTH, 0, 1)
    return share


def rank_grasps(
    center: Floats, axis: Floats, width: Floats, depth: Floats, quality: Floats
) -> list[Grasp]:
    """Candidates as grasps, at most 50, best first: n fields of `Grasp`, axes (n, 2)."""
    angle = np.arctan2(axis[:, 1], axis[:, 0])
    columns = np.column_stack([center, angle, width, depth, quality])
    order = np.argsort(-quality, kind="stable")[:MAX_GRASPS]
    return [Grasp((x, y, z), *others) for x, y, z, *others in columns[order].tolist()]


class DetectorError(Exception):
    """A detector raised an error, returned something other than grasps, or ended its process."""


class DetectorTimeoutError(Exception):
    """A detector took too long and was stopped."""

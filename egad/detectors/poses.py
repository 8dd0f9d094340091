"""Grasps in any direction, as detectors propose them and a hand without an arm executes them."""

from typing import Any, NamedTuple, Protocol

import numpy as np

from egad._util.arrays import Floats, Ints
from egad.detectors.base import MAX_GRASPS, Grasp
from egad.grasps import hand_poses
from egad.grippers import Gripper
from egad.tables.outcomes import Outcome

RIGID = 1e-3  # largest entry of R^T R - 1; networks answer in single precision


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


class Detector(Protocol):
    """Proposes grasps for what depth cameras see."""

    def __call__(
        self,
        seen: Any,  # noqa: ANN401 (what it asks for)
        gripper: Gripper,
        rng: np.random.Generator,
        /,
    ) -> list[Grasp] | GraspPoses:
        """Propose grasps, in any order; none if there is nothing to hold.

        The answer may depend on these three alone, not on earlier calls: attempts are spread over
        processes, and each can be repeated by itself.

        Args:
            seen: A view from above, with intrinsics and pose of the camera, or whatever it asks for
                (`wanted_input`); the table is at height 0.
            gripper: The hand that will try.
            rng: The only source of randomness.
        """


class PoseGrasp(NamedTuple):
    """One grasp: its pose (4, 4), how far to open in metres, and its score."""

    pose: Floats
    width: float
    score: float


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


def best_pose(
    grasps: GraspPoses, gripper: Gripper, order: Ints | None = None
) -> PoseGrasp | Outcome:
    """The grasp of the highest score, or the first in `order`, that the hand can execute.

    If there is none: `no_grasp`, or the flaw of the most promising one.
    """
    reason = None
    for number in (by_score(grasps.scores) if order is None else order).tolist():
        grasp = PoseGrasp(
            grasps.poses[number], float(grasps.widths[number]), float(grasps.scores[number])
        )
        flaw = infeasibility(grasp, gripper)
        if flaw is None:
            return grasp
        reason = reason or flaw
    return reason or Outcome.NO_GRASP


def by_score(scores: Floats) -> Ints:
    """Indices of grasps from the highest score down, equals in the order given."""
    return np.argsort(np.where(np.isfinite(scores), -scores, np.inf), kind="stable")


def infeasibility(grasp: PoseGrasp, gripper: Gripper) -> Outcome | None:
    """Why the hand cannot execute this, as the outcome of an attempt; None if it can.

    not_finite: a number is NaN or infinite; not_rigid: the pose is not a rotation and translation;
    too_wide: the hand would have to open wider than it can, or by less than 0; below_table: the
    middle of its fingertips would be under the table.
    """
    pose = grasp.pose
    if not (np.isfinite(pose).all() and np.isfinite([grasp.width, grasp.score]).all()):
        return Outcome.NOT_FINITE
    rotation = pose[:3, :3]
    off = np.abs(rotation.T @ rotation - np.eye(3)).max()
    if off > RIGID or np.linalg.det(rotation) < 0 or np.abs(pose[3] - [0, 0, 0, 1]).max() > RIGID:
        return Outcome.NOT_RIGID
    if not 0 <= grasp.width <= gripper.opening:
        return Outcome.TOO_WIDE
    tip = pose[:3, 3] + gripper.kind.span[1] * pose[:3, 2]
    return Outcome.BELOW_TABLE if tip[2] < 0 else None


def pose_of(grasp: Grasp, gripper: Gripper) -> PoseGrasp:
    """A grasp from above as a pose: its fingertips end at the same place.

    The ring of a suction cup, which goes on until it meets an object, begins at the center.
    """
    axis = np.array([[np.cos(grasp.angle), np.sin(grasp.angle), 0.0]])
    kind = gripper.kind
    height = grasp.tip + kind.span[1] if kind.closes else grasp.center[2]
    center = np.array([[*grasp.center[:2], height]])
    pose = hand_poses(center, axis, np.array([[0.0, 0.0, -1.0]]))[0]
    return PoseGrasp(pose, grasp.width, grasp.quality)

"""The reference: what is possible at an object, learned from grasps that were tried before.

It knows where the object is. It chooses among the labelled grasps of the object and all grasps that
succeeded at it before, whoever proposed them, and takes the one with the highest expected success.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from egad._util.arrays import Floats
from egad.bench.failures.object_runner import ObjectRunner
from egad.detectors import Grasp
from egad.sim import Pose
from egad.tables.columns import POSE_PARTS

NEAR = 0.005  # metres between the middles of the pads of grasps that are alike
ALIKE = np.cos(np.radians(15))  # of the angles between their axes, and between their approaches
REST = tuple(f"rest_{part}" for part in POSE_PARTS)
BEST, WORST = 0.9, 0.5  # expected success of the first and the last labelled grasp, before trials


class Tried(NamedTuple):
    """A grasp that was executed."""

    grasp: Grasp  # its pose, from the frame of the hand to that of the object
    success: bool


class ReferencePolicy:
    """Chooses grasps by the results of similar ones."""

    def __init__(self) -> None:
        """Start without any grasp."""
        self._tried: list[Tried] = []

    def remember(self, rest: Pose, grasp: Grasp, success: bool) -> None:
        """Learn whether a grasp, in the world frame, held an object at rest."""
        self._tried.append(Tried(grasp.moved(np.linalg.inv(rest.matrix)), success))

    def ranked(self, runner: ObjectRunner, rest: Pose) -> list[Grasp]:
        """Grasps of an object where it lies, highest expected success first: prior and attempts."""
        labelled = runner.labelled(rest)
        known = [each.grasp.moved(rest.matrix) for each in self._tried if each.success]
        known = [grasp for grasp in known if runner.can_do(grasp)]
        grasps = [*labelled, *known]
        if not grasps:
            return []
        prior = np.full(len(grasps), WORST)
        prior[: len(labelled)] = np.linspace(BEST, WORST, max(len(labelled), 2))[: len(labelled)]
        expected = self._expected(np.array([each.pose for each in grasps]), rest, prior)
        return [grasps[number] for number in np.argsort(-expected, kind="stable").tolist()]

    def _expected(self, poses: Floats, rest: Pose, prior: Floats) -> Floats:
        """Expected success of grasps at poses (n, 4, 4) with a prior (n,)."""
        if not self._tried:
            return prior
        tried = rest.matrix @ np.array([each.grasp.pose for each in self._tried])
        success = np.array([each.success for each in self._tried], dtype=np.float64)
        apart = np.linalg.norm(poses[:, None, :3, 3] - tried[None, :, :3, 3], axis=2)
        axes, approaches = (
            np.einsum("nk,mk->nm", poses[:, :3, column], tried[:, :3, column]) for column in (0, 2)
        )
        near = (apart <= NEAR) & (np.abs(axes) >= ALIKE) & (approaches >= ALIKE)
        expected: Floats = (near @ success + prior) / (near.sum(axis=1) + 1)
        return expected


def read_attempt(row: Mapping[str, Any]) -> tuple[Pose, Grasp]:
    """Where the object lay, and the grasp, of a row of `tables.failures.FAILURE_ATTEMPTS`."""
    pose = np.eye(4)
    pose[:3] = np.reshape(row["pose"], (3, 4))
    rest = Pose.of([row[name] for name in REST])
    return rest, Grasp.of_pose(pose, row["width"], row["score"])

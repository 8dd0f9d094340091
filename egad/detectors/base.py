"""A grasp from above, as detectors propose it and the hand executes it."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from egad._util.arrays import Floats
from egad.grippers import Gripper
from egad.tables.outcomes import Outcome

MAX_GRASPS = 50  # kept from the candidates of a detector
SEARCH = 0.01  # metres that a suction cup searches beyond where it should meet an object
MIN_DEPTH = 0.005  # metres that the fingertips must reach below the surface that is seen
FULL_DEPTH = 0.02  # metres; nothing is gained by reaching further
WHERE = "detectors"


@dataclass(frozen=True)
class Grasp:
    """A vertical grasp of a parallel-jaw hand or a suction cup.

    Attributes:
        center: Where the pads should meet the object: midpoint of the contacts, world frame, m.
            For a cup, where the middle of its ring should.
        angle: Angle of the closing axis about the vertical, from the world's x axis, radians.
        width: How far to open, metres; 0 for a cup.
        depth: How far the fingertips reach below the center, metres. A cup goes at most this far to
            find the object, and stops where its ring lies on it.
        quality: What the detector expects of it; the highest is tried.
    """

    center: tuple[float, float, float]
    angle: float
    width: float
    depth: float
    quality: float

    @property
    def tip(self) -> float:
        """Height of the fingertips above the table, metres."""
        return self.center[2] - self.depth

    def infeasibility(self, gripper: Gripper) -> Outcome | None:
        """Why the hand cannot execute this, as the outcome of an attempt; None if it can.

        not_finite: a number is NaN or infinite; too_wide: it would have to open wider than it can,
        or by less than 0; below_table: the fingertips would be under the table.
        """
        numbers = (*self.center, self.angle, self.width, self.depth, self.quality)
        if not all(map(math.isfinite, numbers)):
            return Outcome.NOT_FINITE
        if not 0 <= self.width <= gripper.opening:
            return Outcome.TOO_WIDE
        return Outcome.BELOW_TABLE if self.tip < 0 else None


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


def best_grasp(grasps: Sequence[Grasp], gripper: Gripper) -> Grasp | Outcome:
    """The grasp of the highest quality that the hand can execute, the first of equals.

    Returns:
        The grasp; or why there is none: `no_grasp`, or the flaw of the most promising one.
    """
    return first_possible(sorted(grasps, key=_promise), gripper)


def first_possible(grasps: Iterable[Grasp], gripper: Gripper) -> Grasp | Outcome:
    """The first grasp that the hand can execute; or why there is none, as for `best_grasp`."""
    reason = None
    for grasp in grasps:
        flaw = grasp.infeasibility(gripper)
        if flaw is None:
            return grasp
        reason = reason or flaw
    return reason or Outcome.NO_GRASP


def _promise(grasp: Grasp) -> float:
    return -grasp.quality if math.isfinite(grasp.quality) else math.inf


class DetectorError(Exception):
    """A detector raised an error, returned something other than grasps, or ended its process."""


class DetectorTimeoutError(Exception):
    """A detector took too long and was stopped."""

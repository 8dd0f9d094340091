"""A grasp from above, as detectors propose it and the hand executes it."""

import math
from dataclasses import astuple, dataclass

from egad.settings import Gripper


@dataclass(frozen=True)
class Grasp:
    """A vertical grasp of a parallel-jaw hand.

    Attributes:
        center: Where the pads should meet the object: midpoint of the contacts, world frame, m.
        angle: Of the closing axis about the vertical, from the world's x axis, radians.
        width: How far to open, metres.
        depth: How far the fingertips reach below the center, metres.
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

    def fits(self, gripper: Gripper) -> bool:
        """Whether all numbers are finite and the hand can open as wide as asked."""
        center, *rest = astuple(self)
        finite = all(math.isfinite(number) for number in (*center, *rest))
        return finite and 0 <= self.width <= gripper.opening

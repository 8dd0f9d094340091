"""Whether what a hand holds has come to rest in it, so that nothing more needs to be simulated."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from egad.sim.gripper import Hand
from egad.sim.world import TIME_STEP

Floats = NDArray[np.float64]

# The motion is that over some time, not that of an instant: a swinging object stands still at its
# turning points. Around such a point, a pendulum of 5 cm still moves by a quarter of its amplitude.
WINDOW = 0.1  # seconds
STRIDE = 6  # steps from one look to the next
CREEP = 0.001  # metres that it may still move until the end, at the rate of the window


class _Held(NamedTuple):
    """Position and quaternion of the object, seen from the hand, and how far the hand is open."""

    position: Floats
    quaternion: Floats
    opening: float


class Stillness:
    """Tells from when on an object lies still in a hand that is level and does not turn."""

    def __init__(self, hand: Hand, start: float, end: float) -> None:
        """Begin to watch.

        Args:
            hand: What holds the object.
            start: Seconds from now in which the object cannot be at rest yet.
            end: Seconds from now until which it must stay in the hand.
        """
        self._hand = hand
        points = hand.world.model.mesh.vertices  # the origin is the centre of mass
        self._reach = float(np.linalg.norm(points, axis=1).max())
        self._early, self._left = round(start / TIME_STEP), round(end / TIME_STEP)
        self._window = round(WINDOW / TIME_STEP)
        self._before, self._steps = self._held(), 0

    def __call__(self) -> bool:
        """Whether the object lies still; to be asked once after every step.

        It does if no point of it moved so far within the last 0.1 s that, at this rate, it would
        move by more than 1 mm until the end.
        """
        self._early, self._left, self._steps = self._early - 1, self._left - 1, self._steps + 1
        if self._early == 0:
            self._before, self._steps = self._held(), 0
        if self._early >= 0 or self._steps % STRIDE:
            return False
        allowed = CREEP * self._window / max(self._left, self._window)
        if self._motion() > allowed:
            self._before, self._steps = self._held(), 0
        return self._steps >= self._window

    def _held(self) -> _Held:
        pose = self._hand.world.pose()
        below = np.array([0.0, 0.0, self._hand.height()])
        return _Held(pose.position - below, pose.quaternion, self._hand.opening())

    def _motion(self) -> float:
        """How far any point of the object moved against the hand, at most, metres."""
        now, before = self._held(), self._before
        shift = float(np.linalg.norm(now.position - before.position))
        # Small rotations: the distance of two unit quaternions is half the angle between them.
        ways = (now.quaternion - before.quaternion, now.quaternion + before.quaternion)
        angle = 2 * min(float(np.linalg.norm(way)) for way in ways)
        return shift + angle * self._reach + abs(now.opening - before.opening)

"""What closes a hand in an engine: two fingers, one jaw or a vacuum, and joints that follow."""

from dataclasses import dataclass

import numpy as np
from typing_extensions import override

from egad._util.arrays import Floats
from egad.grasps.suction import resists
from egad.grippers import SuctionCup

LEFT, RIGHT = "left", "right"  # fingers
DEGREE = 4  # of the polynomials between joints, as in MuJoCo


class Drive:
    """What closes a hand. This one has no joints."""

    joints: tuple[str, ...] = ()  # names of the joints that close it
    strength = 0.0  # force or torque of each, N or N m
    closing = -1.0  # how far each moves per metre that its pad moves inwards, with the direction
    mirrored = True  # whether the hand is its own mirror image; both fingers move, if it has any
    welds = False  # whether it can hold an object without pressing on it: see `World.attach`

    def position(self, opening: float) -> float:
        """Position of each joint at an opening: the distance of its pad from the middle, metres."""
        return opening / 2

    def pads(self, positions: Floats, speeds: Floats) -> tuple[Floats, Floats]:
        """Distances of both pads from their middle, and their speeds: (2,) each, m and m/s."""
        return positions, speeds

    def aside(self, opening: float) -> float:
        """How far the middle between the pads is beside TIP at an opening, along x, metres."""
        del opening
        return 0.0

    def resists(self, load: Floats, friction_factor: float) -> bool:
        """Whether it holds a load (`World.load`), with its friction times a factor."""
        del load, friction_factor
        return False


class FingerDrive(Drive):
    """Two fingers that mirror each other."""

    joints = (LEFT, RIGHT)

    def __init__(self, force: float) -> None:
        """Take the closing force, newtons."""
        self.strength = force


@dataclass(eq=False)
class JawDrive(Drive):
    """One moving jaw."""

    joint: str  # name of its joint
    openings: Floats  # (k,) distances of the pads, ascending, metres
    positions: Floats  # (k,) its positions there, metres or radians
    lever: float  # its torque per newton between the pads, metres; 1 if it slides
    force: float  # closing force, newtons
    mirrored = False

    def __post_init__(self) -> None:
        self.joints, self.strength = (self.joint,), self.force * self.lever
        self.closing = float(np.sign(self.positions[0] - self.positions[-1])) / self.lever

    @override
    def position(self, opening: float) -> float:
        return float(np.interp(opening, self.openings, self.positions))

    @override
    def pads(self, positions: Floats, speeds: Floats) -> tuple[Floats, Floats]:
        order = slice(None, None, 1 if self.positions[-1] > self.positions[0] else -1)
        known, openings = self.positions[order], self.openings[order]
        slopes, position = np.gradient(openings, known), float(positions[0])
        opening = float(np.interp(position, known, openings))
        speed = float(speeds[0]) * float(np.interp(position, known, slopes))
        return np.full(2, opening / 2), np.full(2, speed / 2)

    @override
    def aside(self, opening: float) -> float:
        return (opening - float(self.openings[0])) / 2


class CupDrive(Drive):
    """A suction cup, which a vacuum holds to an object."""

    welds = True

    def __init__(self, cup: SuctionCup) -> None:
        """Take the cup."""
        self._cup = cup

    @override
    def resists(self, load: Floats, friction_factor: float) -> bool:
        return bool(resists(self._cup, load[None], friction_factor * self._cup.friction)[0])


@dataclass(frozen=True, eq=False)
class Follower:
    """A joint of a linkage, whose position follows from that of a finger."""

    joint: str  # its name
    side: str  # the finger
    distances: Floats  # (k,) distances of that finger's pad from the middle, ascending, metres
    positions: Floats  # (k,) positions of the joint, metres or radians

    def at(self, distance: float) -> float:
        """Its position when the pad is this far from the middle."""
        return float(np.interp(distance, self.distances, self.positions))

    def slope(self, distance: float) -> float:
        """Derivative of its position with respect to the distance of the pad."""
        step = float(np.diff(self.distances).mean())
        return (self.at(distance + step) - self.at(distance - step)) / (
            min(distance + step, float(self.distances[-1]))
            - max(distance - step, float(self.distances[0]))
        )

    def polynomial(self) -> Floats:
        """Coefficients of its position as a polynomial of the distance, constant term first."""
        fitted = np.polynomial.Polynomial.fit(self.distances, self.positions, DEGREE).convert()
        return np.pad(fitted.coef, (0, DEGREE + 1 - len(fitted.coef)))

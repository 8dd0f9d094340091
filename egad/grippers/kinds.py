"""The kinds of grippers, and what other code asks of them.

Tables that say how each kind samples grasps, or how an engine moves it, have its name as the key.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

ANTIPODAL, SUCTION = "antipodal", "suction"  # samplers


class Kind(ABC):
    """A kind of gripper, with the sizes of one."""

    name: ClassVar[str]  # key in tables
    noun: ClassVar[str]  # what such a gripper has
    sampler: ClassVar[str]  # of its grasps
    closes: ClassVar[bool]  # on an object, and opens by some width; else it goes on until contact
    lifts: ClassVar[bool]  # whether the quality of its grasps depends on the weight of the object

    @property
    @abstractmethod
    def span(self) -> tuple[float, float]:
        """Where fingers or cup begin and end along the approach, metres from the contacts."""

    @abstractmethod
    def described(self, opening: str) -> str:
        """Such a gripper, with its opening, in words."""


@dataclass(frozen=True)
class JawKind(Kind):
    """Two jaws, of which both move, or one: length and width of a finger, and its tip, metres."""

    name, noun, sampler, closes, lifts = "jaws", "jaws", ANTIPODAL, True, False
    length: float
    width: float
    tip: float | None

    @property
    def span(self) -> tuple[float, float]:
        """A fingertip without a setting is half a finger's width beyond the contacts."""
        tip = min(self.width, self.length) / 2 if self.tip is None else self.tip
        return tip - self.length, tip

    def described(self, opening: str) -> str:
        """Jaws with their opening."""
        return f"jaws that open {opening}"


@dataclass(frozen=True)
class CupKind(Kind):
    """A suction cup; its height, metres."""

    name, noun, sampler, closes, lifts = "cup", "a suction cup", SUCTION, False, True
    height: float

    @property
    def span(self) -> tuple[float, float]:
        """The contact of a cup is the middle of its ring."""
        return -self.height, 0.0

    def described(self, opening: str) -> str:
        """A cup, whose opening is that of jaws."""
        return f"a suction cup, objects as for {opening}"

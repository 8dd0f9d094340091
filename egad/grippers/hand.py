"""The body of a hand: what all kinds of grippers answer, and the convex parts that it is made of.

The frame of the hand has its origin midway between the pads. x is the closing axis, from the first
contact to the second; z is the approach, along which the hand moves towards the object;
y = z cross x. Fingers that are boxes have the contacts in the middle of square pads at their ends,
so the fingertips reach half a finger's width beyond the origin. The palm begins where they end.

A hand with one moving jaw is placed with its fixed jaw, at negative x, before the first contact.
The origin of a suction cup is the middle of its ring.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import trimesh
from scipy.spatial import ConvexHull, QhullError

from egad._util.arrays import Floats, Ints
from egad.errors import RejectedError, UserError
from egad.grippers.parameters import Gripper, SuctionCup

CLEARANCE = 1e-4  # metres between a contact as wide as the opening and the finger
# metres between a contact and the fixed jaw of an open hand that has one; its convex parts fill up
# to half of it
JAW_CLEARANCE = 1e-3
PRISM_SIDES = 16


class Part(NamedTuple):
    """A convex part of a hand."""

    box: Floats  # (2, 3) low and high corner of its bounding box, metres
    # (k, 4) outward unit normals and offsets; where all `normal . point + offset` are negative is
    # the part; without planes, it fills its box
    planes: Floats
    middle: Floats  # (3,) a point in it, metres


class Pieces(NamedTuple):
    """Parts of n hands that differ only by a shift."""

    rows: Ints  # (m,) which of the hands
    parts: list[Part]
    shifts: Floats  # (m, 3) by which each is shifted, in the frame of the hand, metres


class HandBody(ABC):
    """The body of a gripper at any opening: what collisions and drawings ask of each kind."""

    gripper: Gripper

    @abstractmethod
    def parts(self, retreat: float = 0.0) -> list[Part]:
        """The open hand, swept back along its straight approach by `retreat`, metres."""

    def pieces(self, openings: Floats, retreat: float = 0.0) -> Iterator[Pieces]:
        """Hands that are open by `openings`, (n,) metres, swept back by `retreat`."""
        count = len(openings)
        yield Pieces(np.arange(count), self.parts(retreat), np.zeros((count, 3)))

    @abstractmethod
    def shapes(self, opening: float) -> list[tuple[trimesh.Trimesh, int]]:
        """Convex meshes of a hand, pads at the origin, with what each is: a body of `HandLink`."""

    def reach(self, openings: Floats) -> Floats:
        """Position along the approach of pads that move on an arc, (n,) metres, plus a constant."""
        return np.zeros_like(openings)

    def aside(self, widths: Floats, openings: Floats, clearance: float = JAW_CLEARANCE) -> Floats:
        """Where the middle of pads lies on the closing axis, the contacts around 0, (n,) metres."""
        del openings, clearance
        return np.zeros_like(widths)


def check_jaws(gripper: Gripper, what: str) -> None:
    """Raise `UserError` unless a gripper has jaws, which something needs: its subject."""
    if not gripper.kind.closes:
        raise UserError(f"{what} needs a gripper with two jaws; this one has {gripper.kind.noun}")


def cup_of(gripper: Gripper, what: str) -> SuctionCup:
    """The cup of a gripper, which something needs; `UserError` if it has none."""
    if gripper.cup is None:
        raise UserError(f"{what} is for suction cups; the gripper has {gripper.kind.noun}")
    return gripper.cup


def finger_span(gripper: Gripper) -> tuple[float, float]:
    """Where fingers begin and end along the approach, metres from the contacts; or `UserError`."""
    check_jaws(gripper, "the span of the fingers")
    return gripper.kind.span


def box_part(low: list[float], high: list[float]) -> Part:
    """The box between two corners."""
    box = np.array([low, high])
    return Part(box, np.empty((0, 4)), box.mean(axis=0))


def hull_part(points: Floats, retreat: float) -> Part:
    """The convex hull of points, swept along -z."""
    swept = np.vstack([points, points - [0, 0, retreat]])
    try:
        corners = points[ConvexHull(points).vertices]
        planes = np.unique(np.round(ConvexHull(swept).equations, 12), axis=0)
    except QhullError as error:
        raise RejectedError("one of its bodies is flat") from error
    return Part(np.stack([swept.min(axis=0), swept.max(axis=0)]), planes, corners.mean(axis=0))


def prism_part(radius: float, low: float, high: float) -> Part:
    """A prism around a cylinder along the z axis."""
    angles = 2 * np.pi * np.arange(PRISM_SIDES) / PRISM_SIDES
    around = np.stack([np.cos(angles), np.sin(angles), 0 * angles, 0 * angles - radius], axis=1)
    planes = np.vstack([around, [0, 0, 1, -high], [0, 0, -1, low]])
    corner = radius / np.cos(np.pi / PRISM_SIDES)
    box = np.array([[-corner, -corner, low], [corner, corner, high]])
    return Part(box, planes, box.mean(axis=0))

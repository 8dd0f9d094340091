"""A two-jaw hand as its maker describes it: its shape and joints at every opening."""

from dataclasses import dataclass, field
from typing import Literal, NamedTuple

import numpy as np
import trimesh

from egad._util.arrays import Floats

PALM_BODY, FIRST_FINGER, SECOND_FINGER = 0, -1, 1  # what a link belongs to
FINGERS = (FIRST_FINGER, SECOND_FINGER)


class LinkJoint(NamedTuple):
    """How a link moves on the one that carries it."""

    name: str  # name in the description
    kind: Literal["prismatic", "revolute"]
    axis: Floats  # unit vector that it moves along or about, in the frame of the link
    anchor: Floats  # a point of the axis, in the frame of the link, metres
    zero: float  # its position when the link is at its `place`


class HandLink(NamedTuple):
    """A rigid part of a hand."""

    name: str  # name in the description
    body: int  # PALM_BODY, FIRST_FINGER (the finger at negative x) or SECOND_FINGER
    shapes: tuple[Floats, ...]  # (n, 3) corners of convex parts, in its own frame, metres
    mass: float  # kilograms
    carrier: int  # number of the link that carries it; -1 for the palm, and for links that carry it
    place: Floats  # (4, 4) pose in the frame of the carrier when its joint is at `zero`
    joint: LinkJoint | None  # how it moves on the carrier, if it does


@dataclass(frozen=True, eq=False)
class HandModel:
    """Shape and joints of a hand at every opening, in metres and radians.

    The frame of the hand has its origin midway between the pads of the closed hand; x is the
    closing axis, z the approach. It does not move when the fingers do.
    """

    links: tuple[HandLink, ...]  # the first one is the palm
    openings: Floats  # (k,) distances between the middles of the pads, from closed to open
    reach: Floats  # (k,) height of the middle between the pads along z; 0 when closed
    aside: Floats  # (k,) the same along x: half the opening of a hand with one moving jaw
    angles: Floats  # (k,) between the inner faces of one moving jaw and the fixed one, else 0;
    # positive if they are farther apart at the tips
    turns: Floats  # (k, l, 3, 3) rotations of the links in the frame of the hand
    places: Floats  # (k, l, 3) positions of the links in the frame of the hand
    joints: tuple[str, ...]  # names of the joints that move, the driven ones first
    n_driven: int  # several if each finger has its own drive
    positions: Floats  # (k, j) of the joints
    palm_to_hand: Floats  # (4, 4) pose of the frame of the hand in that of the palm
    pad: Floats  # (2, 3) low and high corner of both pads, when closed, in the frame of the hand
    # Openings are between the foremost points of the pads. The fraction of their faces that lies
    # further back, and how much farther apart their rearmost points are.
    recess: tuple[float, float] = (0.0, 0.0)
    # torque of the joint of one moving jaw per newton between the pads; 1 if it slides; None if
    # both fingers move
    lever: float | None = None
    # (d,) depths along its fixed jaw, beyond the pads along z; (k, d) gaps between the inner faces
    # there, along x, NaN where one of them is missing
    depths: Floats = field(default_factory=lambda: np.empty(0))
    gaps: Floats = field(default_factory=lambda: np.empty((0, 0)))

    @property
    def joint_kind(self) -> str:
        """How the first driven joint moves: prismatic or revolute."""
        kinds = {link.joint.name: link.joint.kind for link in self.links if link.joint}
        return kinds[self.joints[0]]

    def joint_positions(self, opening: float) -> dict[str, float]:
        """Positions of the joints at an opening, metres or radians."""
        found = [np.interp(opening, self.openings, column) for column in self.positions.T]
        return dict(zip(self.joints, map(float, found), strict=True))

    def opening_at(self, position: float) -> float:
        """The opening at a position of the driven joint."""
        driven = self.positions[:, 0]
        order = slice(None, None, 1 if driven[-1] > driven[0] else -1)
        return float(np.interp(position, driven[order], self.openings[order]))

    def reach_at(self, openings: Floats) -> Floats:
        """Height of the middle between the pads at openings, metres."""
        return np.asarray(np.interp(openings, self.openings, self.reach))

    def middle_at(self, openings: Floats) -> Floats:
        """The middle between the pads at openings, (n, 3) in the frame of the hand, metres."""
        aside = np.interp(openings, self.openings, self.aside)
        return np.stack([aside, np.zeros_like(aside), self.reach_at(openings)], axis=-1)

    def angle_at(self, openings: Floats) -> Floats:
        """Angle between the inner faces of the jaws at openings, radians."""
        return np.asarray(np.interp(openings, self.openings, self.angles))

    def points(self, opening: float) -> list[list[Floats]]:
        """Corners of the convex parts of each link at an opening, in the frame of the hand."""
        turns, places = self.poses(opening)
        return [
            [shape @ turn.T + place for shape in link.shapes]
            for link, turn, place in zip(self.links, turns, places, strict=True)
        ]

    def corners(self, opening: float, *bodies: int) -> list[Floats]:
        """Corners of the convex parts of some bodies (of all: none given), each (n, 3), metres."""
        links = zip(self.links, self.points(opening), strict=True)
        chosen = [shapes for link, shapes in links if not bodies or link.body in bodies]
        return [points for shapes in chosen for points in shapes]

    def shapes(self, opening: float) -> list[tuple[trimesh.Trimesh, int]]:
        """The convex parts as meshes in the frame of the hand, each with its `HandLink.body`."""
        return [
            (trimesh.convex.convex_hull(points), link.body)
            for link, shapes in zip(self.links, self.points(opening), strict=True)
            for points in shapes
        ]

    def poses(self, opening: float) -> tuple[Floats, Floats]:
        """Rotations (l, 3, 3) and positions (l, 3) of the links, in the frame of the hand."""
        level = np.interp(opening, self.openings, np.arange(len(self.openings)))
        low = min(int(level), len(self.openings) - 2)
        part = level - low
        turns = (1 - part) * self.turns[low] + part * self.turns[low + 1]
        return turns, (1 - part) * self.places[low] + part * self.places[low + 1]

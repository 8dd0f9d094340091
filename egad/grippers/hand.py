"""The body of a hand with two jaws: convex parts of boxes, of a palm mesh, or of a maker's model.

The frame of the hand has its origin midway between the pads. x is the closing axis, from the first
contact to the second; z is the approach, along which the hand moves towards the object;
y = z cross x. Fingers that are boxes have the contacts in the middle of square pads at their ends,
so the fingertips reach half a finger's width beyond the origin. The palm begins where they end.

A hand with one moving jaw is placed with its fixed jaw, at negative x, before the first contact.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import trimesh
from scipy.spatial import ConvexHull, QhullError
from typing_extensions import override

from egad import io
from egad._util.arrays import Floats, Ints
from egad.errors import RejectedError, UserError
from egad.grippers.model import FIRST_FINGER, PALM_BODY, SECOND_FINGER, HandModel
from egad.grippers.parameters import Gripper
from egad.grippers.robot import model_of

CLEARANCE = 1e-4  # metres between a contact as wide as the opening and the finger
# metres between a contact and the fixed jaw of an open hand that has one; its convex parts fill up
# to half of it
JAW_CLEARANCE = 1e-3
FINGERS = (FIRST_FINGER, SECOND_FINGER)
BODIES = (PALM_BODY, *FINGERS)


class Part(NamedTuple):
    """A convex part of a hand.

    Attributes:
        box: (2, 3) low and high corner of its bounding box, metres.
        planes: (k, 4) outward unit normals and offsets: the part is where normal . point + offset
            is positive for none of them. Without planes, it fills its box.
        middle: (3,) a point in it, metres.
    """

    box: Floats
    planes: Floats
    middle: Floats


class Pieces(NamedTuple):
    """Parts of n hands that differ only by a shift."""

    rows: Ints  # (m,) which of the hands
    parts: list[Part]
    shifts: Floats  # (m, 3) by which each is shifted, in the frame of the hand, metres


class HandBody(ABC):
    """The body of a hand at any opening.

    Attributes:
        gripper: Its settings.
    """

    gripper: Gripper

    @abstractmethod
    def parts(self, retreat: float = 0.0) -> list[Part]:
        """The open hand, swept back along its straight approach by `retreat`, metres."""

    @abstractmethod
    def pieces(self, openings: Floats, retreat: float = 0.0) -> Iterator[Pieces]:
        """Hands that are open by `openings`, (n,) metres, swept back by `retreat`."""

    @abstractmethod
    def reach(self, openings: Floats) -> Floats:
        """Position of the pads along the approach while they close, (n,) metres.

        The pads of linkages move on an arc. Only differences between openings matter.
        """

    def aside(self, widths: Floats, openings: Floats, clearance: float = JAW_CLEARANCE) -> Floats:
        """Position of the midpoint between the pads along the closing axis, (n,) metres.

        Args:
            widths: (n,) distances between contacts, metres; their middle is at 0.
            openings: (n,) openings of a hand that is to close on them.
            clearance: Distance between the first contact and a fixed jaw, metres.
        """
        del openings, clearance
        return np.zeros_like(widths)


class BoxBody(HandBody):
    """Two finger boxes, and a palm that is a box or a mesh."""

    def __init__(self, gripper: Gripper, palm: trimesh.Trimesh | None = None) -> None:
        """Make a body.

        Args:
            gripper: Sizes of the boxes.
            palm: A mesh that replaces the palm box. Its origin is the middle of the palm's face,
                where the fingers begin, its axes are those of the hand, its unit is the metre. Each
                of its bodies is replaced by its convex hull.

        Raises:
            RejectedError: A body of the mesh is flat.
            UserError: The gripper has a suction cup.
        """
        check_jaws(gripper, "the body of a hand")
        self.gripper, self._palm = gripper, palm
        self.parts()

    @override
    def parts(self, retreat: float = 0.0) -> list[Part]:
        """First finger (at negative x), second finger, palm; swept back by `retreat`, metres."""
        gripper = self.gripper
        inner = gripper.opening / 2 + CLEARANCE
        outer = inner + gripper.finger_thickness
        base, tip = finger_span(gripper)
        side = gripper.finger_width / 2
        fingers = [
            _box([-outer, -side, base - retreat], [-inner, side, tip]),
            _box([inner, -side, base - retreat], [outer, side, tip]),
        ]
        if self._palm is None:
            half, back = np.array(gripper.palm) / 2, base - gripper.palm[2] - retreat
            return [*fingers, _box([-half[0], -half[1], back], [half[0], half[1], base])]
        shift = np.array([0, 0, base])
        pieces = self._palm.split(only_watertight=False)
        return [*fingers, *(_hull(np.asarray(each.vertices) + shift, retreat) for each in pieces)]

    @override
    def pieces(self, openings: Floats, retreat: float = 0.0) -> Iterator[Pieces]:
        first, second, *palm = self.parts(retreat)
        rows, shifts = np.arange(len(openings)), np.zeros((len(openings), 3))
        shifts[:, 0] = (self.gripper.opening - openings) / 2
        yield Pieces(rows, [first], shifts)
        yield Pieces(rows, [second], -shifts)
        yield Pieces(rows, palm, np.zeros_like(shifts))

    @override
    def reach(self, openings: Floats) -> Floats:
        return np.zeros_like(openings)


class ModelBody(HandBody):
    """The links of a maker's model. Openings are rounded up to those that it tabulates.

    Attributes:
        model: Shape and joints.
    """

    def __init__(self, gripper: Gripper, model: HandModel) -> None:
        """Take a model; the gripper has the widest opening that is used."""
        self.gripper, self.model = gripper, model

    @override
    def parts(self, retreat: float = 0.0) -> list[Part]:
        opening = self.gripper.opening
        shift = self.model.middle_at(np.array(opening))
        shapes = [points for link in self.model.points(opening) for points in link]
        return [_hull(points - shift, retreat) for points in shapes]

    @override
    def pieces(self, openings: Floats, retreat: float = 0.0) -> Iterator[Pieces]:
        levels = self._levels(openings)
        for level in np.unique(levels):
            rows = np.flatnonzero(levels == level)
            there = self.model.openings[[level]]
            shifts = self.model.middle_at(there) - self.model.middle_at(openings[rows])
            yield Pieces(rows, self.at(int(level), retreat), shifts)

    @override
    def reach(self, openings: Floats) -> Floats:
        return self.model.reach_at(openings)

    @override
    def aside(self, widths: Floats, openings: Floats, clearance: float = JAW_CLEARANCE) -> Floats:
        if self.model.lever is None:
            return np.zeros_like(widths)
        places = self.model.middle_at(openings) - self.model.middle_at(widths)
        return np.asarray(places[..., 0] - clearance)

    @lru_cache(maxsize=256)  # noqa: B019 (one body lives as long as its stage)
    def at(
        self, level: int, retreat: float = 0.0, *, bodies: tuple[int, ...] = BODIES
    ) -> list[Part]:
        """The hand at one of the tabulated openings, with its pads at the origin.

        Args:
            level: Number of the opening.
            retreat: Length of its straight approach, metres.
            bodies: Which of its bodies, as in `HandLink`.
        """
        opening = float(self.model.openings[level])
        shift = self.model.middle_at(np.array(opening))
        return [
            _hull(points - shift, retreat)
            for link, shapes in zip(self.model.links, self.model.points(opening), strict=True)
            for points in shapes
            if link.body in bodies
        ]

    def _levels(self, openings: Floats) -> Ints:
        """Numbers of the smallest tabulated openings that are at least as wide, (n,)."""
        found = np.searchsorted(self.model.openings, openings - CLEARANCE)
        return np.minimum(found, len(self.model.openings) - 1)


def body_of(gripper: Gripper) -> BoxBody | ModelBody:
    """The body of a hand: that of its file, or boxes. A palm mesh is left out.

    Raises:
        UserError: Its file cannot be used.
    """
    if gripper.file is None:
        return BoxBody(gripper)
    return ModelBody(gripper, model_of(gripper))


def check_jaws(gripper: Gripper, what: str) -> None:
    """Make sure that a gripper has jaws.

    Args:
        gripper: The gripper.
        what: What needs them: the subject of the error message.

    Raises:
        UserError: It has a suction cup.
    """
    if gripper.cup is not None:
        raise UserError(f"{what} needs a gripper with two jaws; this one has a suction cup")


def tip_reach(gripper: Gripper) -> float:
    """How far a hand reaches beyond the origin of its frame, along the approach, metres.

    For jaws, this is from `finger_span`; the origin of a suction cup is in its ring.
    """
    return finger_span(gripper)[1] if gripper.cup is None else 0.0


def finger_span(gripper: Gripper) -> tuple[float, float]:
    """Where the fingers begin and end along the approach, metres from the contacts.

    Raises:
        UserError: The gripper has a suction cup.
    """
    check_jaws(gripper, "the span of the fingers")
    tip = gripper.fingertip
    if tip is None:
        tip = min(gripper.finger_width, gripper.finger_length) / 2
    return tip - gripper.finger_length, tip


def _box(low: list[float], high: list[float]) -> Part:
    box = np.array([low, high])
    return Part(box, np.empty((0, 4)), box.mean(axis=0))


def _hull(points: Floats, retreat: float) -> Part:
    """The convex hull of points, swept along -z."""
    swept = np.vstack([points, points - [0, 0, retreat]])
    try:
        corners = points[ConvexHull(points).vertices]
        planes = np.unique(np.round(ConvexHull(swept).equations, 12), axis=0)
    except QhullError as error:
        raise RejectedError("one of its bodies is flat") from error
    return Part(np.stack([swept.min(axis=0), swept.max(axis=0)]), planes, corners.mean(axis=0))


def hand_body(gripper: Gripper) -> HandBody:
    """The body of a hand: boxes, with a mesh instead of the palm box, or a maker's model.

    Raises:
        UserError: A file cannot be used.
    """
    if gripper.file is not None or gripper.mesh is None:
        return body_of(gripper)
    try:
        return BoxBody(gripper, io.read_mesh(Path(gripper.mesh), "m"))
    except RejectedError as reason:
        raise UserError(
            f"the mesh {gripper.mesh} of a gripper cannot be used: {reason}"
        ) from reason

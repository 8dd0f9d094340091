"""The bodies of hands: boxes, two fingers or one moving jaw of a maker's model, a suction cup."""

from collections.abc import Callable, Iterator
from functools import lru_cache
from pathlib import Path

import numpy as np
import trimesh
from typing_extensions import override

from egad import io
from egad._util.arrays import Floats
from egad.errors import RejectedError, UserError
from egad.grippers.hand import (
    CLEARANCE,
    JAW_CLEARANCE,
    HandBody,
    Part,
    Pieces,
    box_part,
    check_jaws,
    cup_of,
    finger_span,
    hull_part,
    prism_part,
)
from egad.grippers.kinds import CupKind, JawKind
from egad.grippers.model import FIRST_FINGER, PALM_BODY, SECOND_FINGER, HandModel
from egad.grippers.parameters import Gripper, SuctionCup
from egad.grippers.robot import model_of

CIRCLE = 32  # corners of a drawn circle


class BoxBody(HandBody):
    """Two finger boxes, and a palm that is a box or a mesh."""

    def __init__(self, gripper: Gripper, palm: trimesh.Trimesh | None = None) -> None:
        """Take jaws, and a palm mesh, metres, used as hulls; `RejectedError` if one is flat."""
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
            box_part([-outer, -side, base - retreat], [-inner, side, tip]),
            box_part([inner, -side, base - retreat], [outer, side, tip]),
        ]
        if self._palm is None:
            half, back = np.array(gripper.palm) / 2, base - gripper.palm[2] - retreat
            return [*fingers, box_part([-half[0], -half[1], back], [half[0], half[1], base])]
        shift = np.array([0, 0, base])
        solids = self._palm.split(only_watertight=False)
        palm = [hull_part(np.asarray(each.vertices) + shift, retreat) for each in solids]
        return [*fingers, *palm]

    @override
    def pieces(self, openings: Floats, retreat: float = 0.0) -> Iterator[Pieces]:
        first, second, *palm = self.parts(retreat)
        rows, shifts = np.arange(len(openings)), np.zeros((len(openings), 3))
        shifts[:, 0] = (self.gripper.opening - openings) / 2
        yield Pieces(rows, [first], shifts)
        yield Pieces(rows, [second], -shifts)
        yield Pieces(rows, palm, np.zeros_like(shifts))

    @override
    def shapes(self, opening: float) -> list[tuple[trimesh.Trimesh, int]]:
        """A mesh for the palm is shown as a box."""
        pieces = BoxBody(self.gripper).pieces(np.array([opening]))
        return [
            (trimesh.creation.box(bounds=part.box + each.shifts[0]), body)
            for each, body in zip(pieces, (FIRST_FINGER, SECOND_FINGER, PALM_BODY), strict=True)
            for part in each.parts
        ]


class ModelBody(HandBody):
    """The links of a maker's model. Openings are rounded up to those that it tabulates."""

    def __init__(self, gripper: Gripper, model: HandModel) -> None:
        """Take a model; the gripper has the widest opening that is used."""
        self.gripper, self.model = gripper, model

    @override
    def parts(self, retreat: float = 0.0) -> list[Part]:
        opening = self.gripper.opening
        shift = self.model.middle_at(np.array(opening))
        return [hull_part(points - shift, retreat) for points in self.model.corners(opening)]

    @override
    def pieces(self, openings: Floats, retreat: float = 0.0) -> Iterator[Pieces]:
        levels = np.searchsorted(self.model.openings, openings - CLEARANCE)
        levels = np.minimum(levels, len(self.model.openings) - 1)
        for level in np.unique(levels):
            rows = np.flatnonzero(levels == level)
            there = self.model.openings[[level]]
            shifts = self.model.middle_at(there) - self.model.middle_at(openings[rows])
            yield Pieces(rows, self.at(int(level), retreat), shifts)

    @override
    def shapes(self, opening: float) -> list[tuple[trimesh.Trimesh, int]]:
        middle = self.model.middle_at(np.array(opening))
        return [
            (mesh.apply_translation(-middle), body) for mesh, body in self.model.shapes(opening)
        ]

    @override
    def reach(self, openings: Floats) -> Floats:
        return self.model.reach_at(openings)

    @lru_cache(maxsize=256)  # noqa: B019 (one body lives as long as its stage)
    def at(self, level: int, retreat: float = 0.0, *, bodies: tuple[int, ...] = ()) -> list[Part]:
        """The hand, or some bodies, at the opening of this number, with its pads at the origin."""
        opening = float(self.model.openings[level])
        shift = self.model.middle_at(np.array(opening))
        corners = self.model.corners(opening, *bodies)
        return [hull_part(points - shift, retreat) for points in corners]


class JawBody(ModelBody):
    """The same with one moving jaw: the fixed one, at negative x, is before the first contact."""

    def __init__(self, gripper: Gripper, model: HandModel, lever: float) -> None:
        """Take a model and its `lever`."""
        super().__init__(gripper, model)
        self.lever = lever

    @override
    def aside(self, widths: Floats, openings: Floats, clearance: float = JAW_CLEARANCE) -> Floats:
        places = self.model.middle_at(openings) - self.model.middle_at(widths)
        return np.asarray(places[..., 0] - clearance)


class CupBody(HandBody):
    """A suction cup, from its top on, and its stem: what is below it is tested with its seal."""

    def __init__(self, gripper: Gripper) -> None:
        """Take a gripper with a cup."""
        self.gripper, self.cup = gripper, cup_of(gripper, "the body of a cup")

    @override
    def parts(self, retreat: float = 0.0) -> list[Part]:
        return cup_parts(self.cup, retreat)

    @override
    def shapes(self, opening: float) -> list[tuple[trimesh.Trimesh, int]]:
        cup, top = self.cup, -self.cup.height
        flared = [_circle(cup.radius, 0.0), _circle(cup.stem_radius, top)]
        stem = [_circle(cup.stem_radius, top), _circle(cup.stem_radius, top - cup.stem_length)]
        return [
            (trimesh.convex.convex_hull(np.concatenate(rings)), body)
            for rings, body in ((flared, SECOND_FINGER), (stem, PALM_BODY))
        ]


def cup_parts(cup: SuctionCup, retreat: float) -> list[Part]:
    """A cup, from its top on, and its stem, swept back by `retreat`, metres."""
    top = -cup.height
    return [
        prism_part(cup.radius, top - retreat, top),
        prism_part(cup.stem_radius, top - cup.stem_length - retreat, top),
    ]


def _circle(radius: float, height: float) -> Floats:
    turns = 2 * np.pi * np.arange(CIRCLE) / CIRCLE
    return np.stack([radius * np.cos(turns), radius * np.sin(turns), 0 * turns + height], axis=1)


def body_of(gripper: Gripper) -> HandBody:
    """The body of a gripper without its palm mesh; `UserError` if its file cannot be used."""
    return OF_KIND[gripper.kind.name](gripper)


def _jaws(gripper: Gripper) -> HandBody:
    if gripper.file is None:
        return BoxBody(gripper)
    model = model_of(gripper)
    if model.lever is None:
        return ModelBody(gripper, model)
    return JawBody(gripper, model, model.lever)


OF_KIND: dict[str, Callable[[Gripper], HandBody]] = {JawKind.name: _jaws, CupKind.name: CupBody}


def hand_body(gripper: Gripper) -> HandBody:
    """The body of a gripper, with its palm mesh; `UserError` if a file cannot be used."""
    if gripper.file is not None or gripper.mesh is None:
        return body_of(gripper)
    try:
        return BoxBody(gripper, io.read_mesh(Path(gripper.mesh), "m"))
    except RejectedError as reason:
        raise UserError(
            f"the mesh {gripper.mesh} of a gripper cannot be used: {reason}"
        ) from reason

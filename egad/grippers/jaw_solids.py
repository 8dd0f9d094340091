"""The solids of a hand with one moving jaw, and the gap between them."""

from typing import NamedTuple

import numpy as np
import trimesh

from egad._util.arrays import Floats
from egad.errors import UserError
from egad.geometry import RayCaster, joined
from egad.grippers.jaw_faces import Facing, find_facing, solids_of
from egad.grippers.mechanism import Mechanism
from egad.grippers.tree import body_name

BREADTH = np.arange(-4, 5) / 9  # of the breadth of the pads, from their middle
SKIN = 1e-5  # metres in front of a face, where rays start; thinner slices are left where they are
STEEPEST = np.cos(np.radians(75.0))  # how far the face of a jaw may turn away from the other one


class JawFrame(NamedTuple):
    """The directions of a hand with one jaw, in the frame of its palm; unit vectors."""

    closing: Floats  # from the fixed jaw to the moving one
    across: Floats  # along the breadth of the jaws
    approach: Floats  # along the jaws, towards their tips

    @property
    def matrix(self) -> Floats:
        """(3, 3) with the directions in its columns."""
        return np.stack(self, axis=1)


class JawPads(NamedTuple):
    """The pads of both jaws."""

    middle: Floats  # (3,) middle of the fixed pad, in the frame of the palm, metres
    extent: Floats  # breadth and length of both, metres
    bridge: Floats  # (3,) middle of the moving pad, along its `axes`, metres
    axes: Floats  # (3, 3) closing, across and approach in the frame of the moving link, in rows
    recess: tuple[float, float]  # as in `GripperModel`


class JawSolids:
    """The solids of both jaws of a hand.

    Attributes:
        mechanism: The joints.
        body: Number of the link that moves.
        moving_solids: Its solids, in its frame.
        solids: The solids that do not move, in the frame of the palm.
        middle: The middle of their volume.
        facing: How they face each other.
    """

    def __init__(self, mechanism: Mechanism, body: int, static: list[int]) -> None:
        """Read the shapes of a hand with one driven joint; the first static link is the palm."""
        model = mechanism.model
        self.mechanism, self.body = mechanism, body
        self.moving_solids = solids_of(model, body)
        turns, places = mechanism.placement(mechanism.middle())
        self.solids = [
            _placed(solid, turns[each], places[each])
            for each in static
            for solid in solids_of(model, each)
        ]
        if not self.solids:
            raise UserError(
                f"its jaws never face each other: only the link {body_name(model, body)} has "
                "collision shapes"
            )
        volumes = [solid.volume for solid in self.solids]
        self.middle: Floats = np.average(
            [solid.center_mass for solid in self.solids], axis=0, weights=volumes
        )
        self._fixed = RayCaster(joined(self.solids))
        self._moving = RayCaster(joined(self.moving_solids))
        self.facing: Facing = find_facing(mechanism, body, self._moving, self._fixed)

    def positions(self, joint: float) -> Floats:
        """Positions of all joints at a position of the driven joint."""
        return self.mechanism.follow(np.array([joint]), self.mechanism.model.qpos0)

    def angle(self, joint: float, frame: JawFrame) -> float:
        """Angle between the inner faces, radians; positive if they open towards the tips."""
        turn = self.mechanism.placement(self.positions(joint)).turns[self.body]
        normal = turn @ self.facing.normal
        return float(np.arctan2(normal @ frame.approach, -normal @ frame.closing))

    def gaps(self, starts: Floats, joint: float, frame: JawFrame) -> Floats:
        """Distances (n,) from points along the closing axis to the moving jaw's inner face, metres.

        Infinite where a ray meets nothing, or another side of the jaw, negative infinity within the
        jaw.
        """
        turns, places = self.mechanism.placement(self.positions(joint))
        turn, place = turns[self.body], places[self.body]
        ahead = np.tile(frame.closing @ turn, (len(starts), 1))
        behind = starts - SKIN * frame.closing  # so that a ray meets a face that it starts on
        return _distances(self._moving, (behind - place) @ turn, ahead) - SKIN

    def gap(self, pads: JawPads, joint: float, frame: JawFrame) -> float:
        """Gap of the inner faces at the pads, metres; NaN where the moving jaw is not there.

        It is that of what protrudes most: holes and grooves in the moving pad are bridged.
        """
        starts = pads.middle + pads.extent[0] * BREADTH[:, None] * frame.across
        gap = float(self.gaps(starts, joint, frame).min())
        turns, places = self.mechanism.placement(self.positions(joint))
        ahead = pads.axes @ turns[self.body].T @ frame.closing
        start = pads.axes @ ((pads.middle - places[self.body]) @ turns[self.body]) - pads.bridge
        if ahead[0] > STEEPEST and gap > -np.inf:
            distance = -start[0] / ahead[0]
            if abs(start[2] + distance * ahead[2]) <= pads.extent[1] / 2:
                gap = min(gap, distance)
        return gap if np.isfinite(gap) else np.nan

    def fixed_face(self, points: Floats, frame: JawFrame) -> Floats:
        """Distances (n,) from the fixed jaw, back along the closing axis, metres.

        Infinite where there is no face, negative infinity within the link.
        """
        back = np.tile(-frame.closing, (len(points), 1))
        return _distances(self._fixed, points, back)


def _distances(caster: RayCaster, starts: Floats, ahead: Floats) -> Floats:
    """Distances to faces that look back; infinite without one, negative infinity within a solid."""
    hits = caster.first_hits(starts, ahead)
    looks = -np.einsum("nk,nk->n", hits.normals, ahead)
    found = np.where(looks > STEEPEST, hits.distances, np.inf)
    return np.where(np.isfinite(hits.distances) & ~hits.entering, -np.inf, found)


def _placed(solid: trimesh.Trimesh, turn: Floats, place: Floats) -> trimesh.Trimesh:
    vertices = np.asarray(solid.vertices) @ turn.T + place
    return trimesh.Trimesh(vertices, solid.faces, process=False)

"""The solids of a hand with one moving jaw, and the gap between them."""

from contextlib import suppress
from typing import NamedTuple

import mujoco
import numpy as np
import trimesh
from scipy.spatial import QhullError
from trimesh.convex import convex_hull

from egad._util.arrays import Flags, Floats
from egad.errors import RejectedError, UserError
from egad.geometry import RayCaster, joined, spread, wind_outwards
from egad.grippers.description import shape_surfaces
from egad.grippers.fingers import snapped
from egad.grippers.mechanism import Mechanism, body_name

POSITIONS = 17  # of the joint, at which faces are compared
RAY_START = 1e-6  # metres in front of a face, where rays that look out start
SPACING = 0.002  # metres between the points on a jaw that look out
SAMPLES = 8000  # of these points at most, each for the same area
FACING = np.cos(np.radians(30.0))  # how far two faces may turn away from each other
ONWARDS = np.cos(np.radians(50.0))  # how far a face may turn away from the way it moves
TILT = np.cos(np.radians(60.0))  # how far faces may tilt along the hinge
ALIKE = np.cos(np.radians(5.0))  # faces that turn less belong to one face, apart from steps
NEAR = 1e-3  # metres: the nearer two faces come to each other, the more they count
DISTAL = 0.4  # of the longest lever: whatever is nearer to the hinge is its bearing
ROUNDING = 0.04  # of directions that are compared
MIN_AREA = 2e-6  # square metres that face each other
SLIDE = mujoco.mjtJoint.mjJNT_SLIDE
BREADTH = np.arange(-4, 5) / 9  # of the breadth of the pads, from their middle
SKIN = 1e-5  # metres in front of a face, where gaps begin; thinner slices are left as they are
STEEPEST = np.cos(np.radians(75.0))  # how far the face of a jaw may turn away from the other one


class Facing(NamedTuple):
    """How two jaws face each other."""

    axis: Floats  # normal of the fixed jaw's inner face, to the other, in the frame of the palm
    normal: Floats  # normal of the moving jaw's inner face, in the frame of its link
    closing: float  # 1 if the jaw closes while the position of its joint grows, else -1
    points: Floats  # (n, 3) of the fixed jaw's face, in the frame of the palm, metres


def solids_of(model: mujoco.MjModel, body: int) -> list[trimesh.Trimesh]:
    """The collision shapes of a link in its frame; open surfaces become their convex hull."""
    solids = []
    for points, faces in shape_surfaces(model, body):
        with suppress(QhullError):  # it is flat, and touches nothing
            try:
                mesh = trimesh.Trimesh(points, faces) if len(faces) else convex_hull(points)
                solids.append(wind_outwards(mesh))
            except RejectedError:
                solids.append(convex_hull(points))
    return solids


def find_facing(mechanism: Mechanism, body: int, moving: RayCaster, fixed: RayCaster) -> Facing:
    """The faces with which a moving jaw closes against a fixed one, or `UserError`.

    Faces that the jaw itself hides do not count. A face is taken as if it did not tilt along a
    hinge, or from the way that a jaw slides. The surfaces are in the frames of the jaw and of the
    palm.
    """
    samples = spread(moving.mesh, SPACING)
    counts = np.bincount(samples.faces, minlength=len(moving.areas))
    sums = np.cumsum((moving.areas / np.maximum(counts, 1))[samples.faces])
    n = min(SAMPLES, len(sums))
    rows = np.minimum(np.searchsorted(sums, sums[-1] * (np.arange(n) + 0.5) / n), len(sums) - 1)
    area, points = float(sums[-1]) / n, (samples.points[rows], samples.normals[rows])
    low, high = mechanism.ranges()[0]
    looks = [
        _looks(mechanism, body, position, *points, moving, fixed)
        for position in np.linspace(low, high, POSITIONS)
    ]
    ways, faces, met, own, gaps = map(np.concatenate, zip(*looks, strict=True))
    closing = float(np.sign(ways.sum()))
    if area * (ways == closing).sum() < MIN_AREA or closing == 0:
        raise UserError(
            f"its jaws never face each other: no face of the moving link "
            f"{body_name(mechanism.model, body)} closes against a fixed one"
        )
    faces, met, own, gaps = (each[ways == closing] for each in (faces, met, own, gaps))
    axis, alike = _prevailing(faces, 1 / (gaps + NEAR))
    normal, _ = _prevailing(own[alike], 1 / (gaps[alike] + NEAR))
    return Facing(axis, normal, closing, met[alike])


def _looks(
    mechanism: Mechanism,
    body: int,
    position: float,
    points: Floats,
    normals: Floats,
    moving: RayCaster,
    fixed: RayCaster,
) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """What k points see that look at a face that looks back, with nothing in between.

    Which way the joint moves them, the normals and points of that face, their own normals in the
    frame of the jaw, and how far away it is.
    """
    positions = mechanism.follow(np.array([position]), mechanism.model.qpos0)
    placement = mechanism.placement(positions)
    turn, place = placement.turns[body], placement.places[body]
    joint = int(mechanism.model.body_jntadr[body])
    axis, slides = mechanism.axis(joint, positions), mechanism.model.jnt_type[joint] == SLIDE
    there, ahead = points @ turn.T + place, _upright(normals @ turn.T, axis, slides)
    velocities, levers = mechanism.velocities(positions, body, there)
    speeds = np.einsum("nk,nk->n", velocities, ahead)
    rows = np.flatnonzero(
        (np.abs(speeds) > ONWARDS * np.linalg.norm(velocities, axis=1))
        & (np.einsum("nk,nk->n", normals @ turn.T, ahead) > TILT)
        & (levers >= DISTAL * levers.max())
    )
    there, ahead = there[rows], np.ascontiguousarray(ahead[rows])
    starts = there + RAY_START * normals[rows] @ turn.T
    hits = fixed.first_hits(starts, ahead)
    faces = _upright(hits.normals, axis, slides)
    seen = hits.entering & (np.einsum("nk,nk->n", faces, ahead) < -FACING)
    seen &= np.einsum("nk,nk->n", faces, hits.normals) > TILT
    own = moving.first_hits((starts[seen] - place) @ turn, ahead[seen] @ turn)
    inside = np.isfinite(own.distances) & ~own.entering
    seen[seen] = ~inside & (own.distances > hits.distances[seen])
    met = there[seen] + hits.distances[seen, None] * ahead[seen]
    ways = np.sign(speeds[rows[seen]])
    return ways, faces[seen], met, ahead[seen] @ turn, hits.distances[seen]


def _upright(normals: Floats, axis: Floats, slides: bool) -> Floats:
    """Unit vectors without their part along a hinge, or only with that along a sliding joint."""
    along = (normals @ axis)[:, None] * axis
    across = along if slides else normals - along
    return np.asarray(across / np.maximum(np.linalg.norm(across, axis=1, keepdims=True), RAY_START))


def _prevailing(normals: Floats, weights: Floats) -> tuple[Floats, Flags]:
    """The direction that most of some unit vectors have, and which."""
    candidates = np.unique(np.round(normals / ROUNDING), axis=0)
    candidates /= np.linalg.norm(candidates, axis=1, keepdims=True)
    near = (normals @ candidates.T > ALIKE).T
    alike = near[int(np.argmax(near @ weights))]
    mean = np.average(normals[alike], axis=0, weights=weights[alike])
    return snapped(mean / np.linalg.norm(mean)), alike


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
    recess: tuple[float, float]  # as in `HandModel`


class JawSolids:
    """The solids of both jaws of a hand, and how they face each other."""

    def __init__(self, mechanism: Mechanism, body: int, static: list[int]) -> None:
        """Read the shapes of a hand with one driven joint; the first static link is the palm."""
        model = mechanism.model
        self.mechanism, self.body = mechanism, body
        self.moving_solids = solids_of(model, body)
        turns, places = mechanism.placement(mechanism.middle())
        self.solids = [
            trimesh.Trimesh(
                np.asarray(solid.vertices) @ turns[each].T + places[each],
                solid.faces,
                process=False,
            )
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
        """Distances (n,) along the closing axis to the moving jaw's face, m, as `_distances`."""
        turns, places = self.mechanism.placement(self.positions(joint))
        turn, place = turns[self.body], places[self.body]
        ahead = np.tile(frame.closing @ turn, (len(starts), 1))
        behind = starts - SKIN * frame.closing  # so that a ray meets a face that it starts on
        return _distances(self._moving, (behind - place) @ turn, ahead) - SKIN

    def gap(self, pads: JawPads, joint: float, frame: JawFrame) -> float:
        """Gap of what protrudes most at the pads, metres; NaN where the moving jaw is not there."""
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
        """Distances (n,) back to the fixed jaw, metres; infinite without one, -infinite within."""
        back = np.tile(-frame.closing, (len(points), 1))
        return _distances(self._fixed, points, back)


def _distances(caster: RayCaster, starts: Floats, ahead: Floats) -> Floats:
    """Distances to faces that look back; infinite without one, negative infinity within a solid."""
    hits = caster.first_hits(starts, ahead)
    looks = -np.einsum("nk,nk->n", hits.normals, ahead)
    found = np.where(looks > STEEPEST, hits.distances, np.inf)
    return np.where(np.isfinite(hits.distances) & ~hits.entering, -np.inf, found)

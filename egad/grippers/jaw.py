"""A hand with one jaw that is fixed to the palm, and one that turns or slides.

The closing axis is the normal of the fixed jaw's inner face. The pads are where both jaws are
closest to each other, which is at the tips for most hands. The opening is the gap between the inner
faces there, along the closing axis, at the middle of their breadth: where a body that lies against
the fixed jaw touches them. The fixed pad stays where it is, so the middle between the pads moves by
half the opening, and faces of a jaw that turns are parallel at one opening only.
"""

from typing import NamedTuple

import numpy as np
import trimesh

from egad._util.arrays import Flags, Floats
from egad.errors import RejectedError, UserError
from egad.geometry import RayCaster, decompose, is_solid, joined, to_mesh, to_solid
from egad.grippers.jaw_faces import FACING, Facing, find_facing, solids_of
from egad.grippers.links import joint_at
from egad.grippers.mechanism import Mechanism
from egad.grippers.model import FIRST_FINGER, PALM_BODY, SECOND_FINGER, HandLink
from egad.grippers.pads import UNEVEN
from egad.grippers.stroke import LEVELS, MAX_OPENING, MIN_OPENING
from egad.grippers.tree import body_name

GRID = 5e-4  # metres, between points of a jaw's face
BREADTH = np.arange(-4, 5) / 9  # of the breadth of the pads, from their middle
DEPTH_STEP = 0.01  # metres, between places along a jaw
MARGIN = 5  # grid points around those that were found on it
FINEST = 201  # points along and across the pads
AHEAD = 2e-3  # metres between the foremost known point of the fixed jaw's face and that grid
SKIN = 1e-5  # metres in front of a face, where rays start; thinner slices are left where they are
PAD_DEPTH = 1e-3  # metres that a pad may lie behind the foremost point of its jaw
CLOSED = 2e-3  # metres that a pad may be further from the other jaw than its foremost point
FINE = 8 * LEVELS  # positions of the joint at which the gap is measured first
STEEPEST = np.cos(np.radians(75.0))  # how far the face of a jaw may turn away from the other one
CONVEX = 0.02  # of a hull: with less excess a shape counts as convex
# How much convex parts may add: depth in hollows, metres, and fraction of the volume
JAW, PALM = (5e-4, 0.1), (2e-3, 0.5)
MAX_PARTS = 64


class JawFrame(NamedTuple):
    """The directions of a hand with one jaw, in the frame of its palm; unit vectors.

    Attributes:
        closing: From the fixed jaw to the moving one.
        across: Along the breadth of the jaws.
        approach: Along the jaws, towards their tips.
    """

    closing: Floats
    across: Floats
    approach: Floats

    @property
    def matrix(self) -> Floats:
        """(3, 3) with the directions in its columns."""
        return np.stack(self, axis=1)


class JawPads(NamedTuple):
    """The pads of both jaws.

    Attributes:
        middle: (3,) middle of the fixed pad, in the frame of the palm, metres.
        extent: Breadth and length of both, metres.
        bridge: (3,) middle of the moving pad, along its `axes`, metres.
        axes: (3, 3) closing, across and approach in the frame of the moving link, in rows.
        recess: As in `GripperModel`.
    """

    middle: Floats
    extent: Floats
    bridge: Floats
    axes: Floats
    recess: tuple[float, float]


class JawStroke(NamedTuple):
    """The way of a jaw from closed to open.

    Attributes:
        positions: (k, q) positions of all joints.
        openings: (k,) gap of the inner faces at the pads, ascending, metres.
        angles: (k,) angles between them, radians; positive if they are farther apart at the tips.
        pads: Where they are measured.
    """

    positions: Floats
    openings: Floats
    angles: Floats
    pads: JawPads


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
        """Read the shapes of a hand.

        Args:
            mechanism: The joints, of which one is driven.
            body: Number of the link that moves.
            static: Numbers of the links that do not move.

        Raises:
            UserError: The jaws never face each other.
        """
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
        """Distances from points along the closing axis to the moving jaw's inner face.

        Args:
            starts: (n, 3) on the fixed jaw's face, in the frame of the palm, metres.
            joint: Position of the driven joint.
            frame: The directions of the hand.

        Returns:
            (n,) metres; infinite where a ray meets nothing, or another side of the jaw, and
            negative infinity within the jaw.
        """
        turns, places = self.mechanism.placement(self.positions(joint))
        turn, place = turns[self.body], places[self.body]
        ahead = np.tile(frame.closing @ turn, (len(starts), 1))
        behind = starts - SKIN * frame.closing  # so that a ray meets a face that it starts on
        return _distances(self._moving, (behind - place) @ turn, ahead) - SKIN

    def gap(self, pads: JawPads, joint: float, frame: JawFrame) -> float:
        """Gap of the inner faces at the pads, metres; NaN where the moving jaw is not there.

        It is that of what protrudes most across their breadth. Holes and grooves in the moving
        pad are bridged.
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
        """Distances of points from the fixed jaw, back along the closing axis.

        Returns:
            (n,) metres; infinite where there is no face, and negative infinity within the link.
        """
        back = np.tile(-frame.closing, (len(points), 1))
        return _distances(self._fixed, points, back)


def _distances(caster: RayCaster, starts: Floats, ahead: Floats) -> Floats:
    """Distances to faces that look back; infinite without one, negative infinity within a solid."""
    hits = caster.first_hits(starts, ahead)
    looks = -np.einsum("nk,nk->n", hits.normals, ahead)
    found = np.where(looks > STEEPEST, hits.distances, np.inf)
    return np.where(np.isfinite(hits.distances) & ~hits.entering, -np.inf, found)


def find_jaw_stroke(jaws: JawSolids, frame: JawFrame, tcp: Floats | None = None) -> JawStroke:
    """Where the pads are, and how far apart they are at each position of the joint.

    Args:
        jaws: The jaws.
        frame: The directions of the hand.
        tcp: Middle of the closed pads in the frame of the palm, metres; found if None.

    Raises:
        UserError: They do not open, or open wider than any hand.
    """
    low, high = jaws.mechanism.ranges()[0]
    closed, wide = (low, high) if jaws.facing.closing < 0 else (high, low)
    joints = np.linspace(closed, wide, FINE)
    angles = np.array([jaws.angle(joint, frame) for joint in joints])
    parallel = int(np.abs(angles).argmin())
    way = np.argsort(angles)
    pads = _find_pads(jaws, frame, joints, float(np.interp(0.0, angles[way], joints[way])))
    if tcp is not None:
        pads = pads._replace(middle=_on_fixed_face(jaws, frame, tcp, pads.middle))
    gaps = np.array([jaws.gap(pads, float(joint), frame) for joint in joints])
    first, last = _useful(gaps, parallel)
    names = f"{body_name(jaws.mechanism.model, jaws.body)} and the fixed jaw"
    if last - first < 1 or gaps[last] < MIN_OPENING:
        raise UserError(f"its links {names} are at most {1000 * gaps[last]:.2g} mm apart")
    if gaps[last] > MAX_OPENING:
        raise UserError(
            f"its links {names} open {gaps[last]:.3g} m; limits of sliding joints are in metres"
        )
    levels = np.linspace(joints[first], joints[last], LEVELS)
    openings = np.array([jaws.gap(pads, float(joint), frame) for joint in levels])
    return JawStroke(
        np.array([jaws.positions(float(joint)) for joint in levels]),
        np.maximum.accumulate(openings),
        np.array([jaws.angle(float(joint), frame) for joint in levels]),
        pads,
    )


def _useful(gaps: Floats, start: int) -> tuple[int, int]:
    """Range of positions around one where the gap is known and grows, except for small steps."""
    known = np.isfinite(gaps)
    if not known.any():
        raise UserError("its jaws never face each other where they are nearest")
    start = int(np.flatnonzero(known)[np.abs(np.flatnonzero(known) - start).argmin()])
    first = last = start
    while first > 0 and gaps[first - 1] < gaps[first] + PAD_DEPTH:
        first -= 1
    while last + 1 < len(gaps) and gaps[last + 1] > gaps[last] - PAD_DEPTH:
        last += 1
    return first, last


def _find_pads(jaws: JawSolids, frame: JawFrame, joints: Floats, parallel: float) -> JawPads:
    """Where the jaws meet first when they close, and what protrudes as far, once parallel.

    Args:
        jaws: The jaws.
        frame: The directions of the hand.
        joints: Positions of the joint, from closed to open.
        parallel: That at which their faces are parallel, or nearly so.
    """
    points, gaps = _opposite(jaws, frame, parallel, _grid(jaws, frame))
    if not len(points):
        raise UserError("its jaws never face each other where their faces are parallel")
    cells = points + GRID / 2 * frame.approach  # their ends that are nearest to the tips
    moved = _squeezes(jaws, frame, parallel, cells + gaps[:, None] * frame.closing)
    if moved.any():
        points, gaps = points[moved], gaps[moved]
    apart = _gaps_before_contact(jaws, frame, joints, points)
    first = int(apart.argmin())
    heights = points @ frame.closing
    ends = heights + gaps
    beside = np.abs((points - points[first]) @ frame.approach) < GRID
    level, end = heights[beside].max(), ends[beside].min()
    both = (np.abs(heights - level) < PAD_DEPTH) & (np.abs(ends - end) < PAD_DEPTH)
    both &= (apart <= apart[first] + CLOSED) | np.isinf(apart)
    both[first] = True
    chosen = points[both] @ frame.matrix
    low, high = chosen[:, 1:].min(axis=0), chosen[:, 1:].max(axis=0)
    middle, extent = (low + high) / 2, high - low + GRID
    fine = _raster(chosen[:, 0].max() + AHEAD, middle, extent) @ frame.matrix.T
    points, gaps = _opposite(jaws, frame, parallel, fine)
    heights = points @ frame.closing
    placement = jaws.mechanism.placement(jaws.positions(parallel))
    turn, place = placement.turns[jaws.body], placement.places[jaws.body]
    face, opposite = float(heights.max()), float((heights + gaps).min())
    bridge = np.array([opposite, *middle]) - place @ frame.matrix
    pad, further = frame.matrix @ np.array([face, *middle]), gaps - (opposite - face)
    recess = (float((further > 2 * UNEVEN).mean()), float(further.max()))
    return JawPads(pad, extent, bridge, frame.matrix.T @ turn, recess)


def _opposite(
    jaws: JawSolids, frame: JawFrame, joint: float, points: Floats
) -> tuple[Floats, Floats]:
    """The points of the fixed jaw's face behind others that have a moving face before them.

    Returns:
        (k, 3) in the frame of the palm, and (k,) gaps there, metres.
    """
    behind = jaws.fixed_face(points, frame)
    here = np.isfinite(behind)
    points = points[here] - behind[here, None] * frame.closing
    gaps = jaws.gaps(points, joint, frame)
    return points[np.isfinite(gaps)], gaps[np.isfinite(gaps)]


def _raster(height: float, middle: Floats, extent: Floats) -> Floats:
    """Points all over the pads, (n, 3): close enough to meet their sharp edges."""
    y, z = np.meshgrid(*(middle[:, None] + np.linspace(-0.5, 0.5, FINEST) * extent[:, None]))
    return np.stack([np.full(y.size, height), y.ravel(), z.ravel()], axis=1)


def _squeezes(jaws: JawSolids, frame: JawFrame, joint: float, points: Floats) -> Flags:
    """Which points of the moving jaw move mostly along the closing axis."""
    velocities, _ = jaws.mechanism.velocities(jaws.positions(joint), jaws.body, points)
    speeds = np.abs(velocities @ frame.closing)
    return np.asarray(speeds > FACING * np.linalg.norm(velocities, axis=1))


def _gaps_before_contact(
    jaws: JawSolids, frame: JawFrame, joints: Floats, points: Floats
) -> Floats:
    """Distances from points of the fixed jaw's face to the other jaw, just before it touches any.

    Args:
        jaws: The jaws.
        frame: The directions of the hand.
        joints: Positions of the joint, from closed to open.
        points: (n, 3) on the fixed jaw's face, in the frame of the palm, metres.
    """
    nearest = np.full(len(points), np.inf)
    for joint in joints[::-8]:
        gaps = jaws.gaps(points, float(joint), frame)
        if np.isneginf(gaps).any():
            break
        if np.isfinite(gaps).any():
            nearest = gaps
    return nearest


def _on_fixed_face(jaws: JawSolids, frame: JawFrame, tcp: Floats, pad: Floats) -> Floats:
    """The point of the fixed jaw's face at the depth and breadth of another point."""
    off = frame.matrix.T @ (tcp - pad)
    start = tcp - off[0] * frame.closing + GRID * frame.closing
    (behind,) = jaws.fixed_face(start[None], frame)
    if not np.isfinite(behind):
        raise UserError("there is no face of the fixed jaw at its tcp")
    return np.asarray(start - behind * frame.closing)


def _grid(jaws: JawSolids, frame: JawFrame) -> Floats:
    """Points just in front of the foremost point of the fixed jaw's face, all over it, (n, 3)."""
    seen = jaws.facing.points @ frame.matrix
    low, high = seen.min(axis=0), seen.max(axis=0)
    across, along = (
        GRID * (np.arange(*np.round([low[axis] / GRID - MARGIN, high[axis] / GRID + MARGIN])) + 0.5)
        for axis in (1, 2)
    )
    y, z = np.meshgrid(across, along, indexing="ij")
    points = np.stack([np.full_like(y, high[0] + AHEAD), y, z], axis=2)
    return np.asarray(points.reshape(-1, 3) @ frame.matrix.T)


def gaps_along(
    jaws: JawSolids, frame: JawFrame, stroke: JawStroke, root: float
) -> tuple[Floats, Floats]:
    """Gaps of the inner faces along the fixed jaw.

    Args:
        jaws: The jaws.
        frame: The directions of the hand.
        stroke: Its pads and the positions of its joint.
        root: Where the fixed jaw begins, along the approach, metres.

    Returns:
        (d,) depths beyond the pads and (k, d) gaps between what protrudes most near the middle of
        their breadth, metres; NaN where one of the faces is missing.
    """
    length = float(stroke.pads.middle @ frame.approach) - root
    depths = -DEPTH_STEP * np.arange(max(int(length / DEPTH_STEP), 0) + 1)
    middles = stroke.pads.middle + SKIN * frame.closing + depths[:, None] * frame.approach
    points = middles + stroke.pads.extent[0] * BREADTH[:, None, None] * frame.across
    shape = points.shape[:2]
    behind = jaws.fixed_face(points.reshape(-1, 3), frame).reshape(shape)
    foremost = np.where(np.isfinite(behind), behind, np.inf).min(axis=0)
    known = np.isfinite(foremost)
    faces = (points - np.where(known, foremost, 0.0)[:, None] * frame.closing).reshape(-1, 3)
    joint = jaws.mechanism.model.jnt_qposadr[jaws.mechanism.driven[0]]
    gaps = np.array([jaws.gaps(faces, float(each[joint]), frame) for each in stroke.positions])
    nearest = gaps.reshape(-1, *shape).min(axis=1)
    return np.asarray(depths), np.where(known & np.isfinite(nearest), nearest, np.nan)


def jaw_root(jaws: JawSolids, frame: JawFrame, stroke: JawStroke) -> float:
    """Where the fixed jaw begins, along the approach: the palm is what protrudes from its face.

    If nothing protrudes, the jaw begins where the hand begins.
    """
    surfaces = np.concatenate([np.asarray(solid.vertices) for solid in jaws.solids])
    lowest = float((surfaces @ frame.approach).min())
    start = float(stroke.pads.middle @ frame.approach)
    depths = np.arange(0.0, start - lowest, GRID)
    line = stroke.pads.middle + PAD_DEPTH * frame.closing - depths[:, None] * frame.approach
    inside = np.isneginf(jaws.fixed_face(line, frame))
    if not inside.any():
        return lowest
    ahead, behind = (float(depths[inside.argmax() - before]) for before in (1, 0))
    while behind - ahead > SKIN / 10:
        middle = (ahead + behind) / 2
        point = stroke.pads.middle + PAD_DEPTH * frame.closing - middle * frame.approach
        if np.isneginf(jaws.fixed_face(point[None], frame)[0]):
            behind = middle
        else:
            ahead = middle
    return start - ahead


def jaw_links(
    jaws: JawSolids, frame: JawFrame, root: float, static: list[int]
) -> tuple[HandLink, HandLink, HandLink]:
    """The palm, the fixed jaw and the moving one, with the convex parts of their shapes.

    Args:
        jaws: The jaws.
        frame: The directions of the hand.
        root: Where the fixed jaw begins, along the approach, metres.
        static: Numbers of the links that do not move; the first one is the palm.
    """
    model = jaws.mechanism.model
    palm: list[trimesh.Trimesh] = []
    finger: list[trimesh.Trimesh] = []
    for solid in jaws.solids:
        for mesh, ahead in _cut(solid, frame.approach, root):
            (finger if ahead else palm).append(mesh)
    name = body_name(model, static[0])
    return (
        HandLink(
            name=name,
            body=PALM_BODY,
            shapes=_parts(palm, *PALM),
            mass=sum(float(model.body_mass[each]) for each in static),
            carrier=-1,
            place=np.eye(4),
            joint=None,
        ),
        HandLink(
            name=f"{name}-fixed-jaw",
            body=FIRST_FINGER,
            shapes=_parts(finger, *JAW),
            mass=0.0,
            carrier=0,
            place=np.eye(4),
            joint=None,
        ),
        _moving_link(jaws),
    )


def _moving_link(jaws: JawSolids) -> HandLink:
    model, body = jaws.mechanism.model, jaws.body
    joint = joint_at(model, int(model.body_jntadr[body]))
    turns, places = jaws.mechanism.placement(jaws.positions(joint.zero))
    place = np.eye(4)
    place[:3, :3], place[:3, 3] = turns[body], places[body]
    return HandLink(
        name=body_name(model, body),
        body=SECOND_FINGER,
        shapes=_parts(jaws.moving_solids, *JAW),
        mass=float(model.body_mass[body]),
        carrier=0,
        place=place,
        joint=joint,
    )


def lever_of(jaws: JawSolids, stroke: JawStroke, frame: JawFrame) -> float:
    """Torque of the joint for a newton along the closing axis at the pads: metres; 1 if it slides.

    The pads stay at one depth, so it is the same at all openings.
    """
    contact = stroke.pads.middle + stroke.openings[-1] * frame.closing
    velocities, _ = jaws.mechanism.velocities(stroke.positions[-1], jaws.body, contact[None])
    return float(abs(velocities[0] @ frame.closing))


def _placed(solid: trimesh.Trimesh, turn: Floats, place: Floats) -> trimesh.Trimesh:
    vertices = np.asarray(solid.vertices) @ turn.T + place
    return trimesh.Trimesh(vertices, solid.faces, process=False)


def _cut(
    mesh: trimesh.Trimesh, normal: Floats, height: float
) -> list[tuple[trimesh.Trimesh, bool]]:
    """The pieces ahead of a plane and behind it, each with whether it lies ahead."""
    heights = np.asarray(mesh.vertices) @ normal
    solid = to_solid(mesh.vertices, mesh.faces)
    one_side = heights.min() >= height - SKIN or heights.max() <= height + SKIN
    if one_side or not is_solid(solid):
        return [(mesh, bool(heights.mean() >= height))]
    halves = solid.split_by_plane(tuple(normal), height)
    return [
        (to_mesh(half), ahead)
        for half, ahead in zip(halves, (True, False), strict=True)
        if is_solid(half)
    ]


def _parts(meshes: list[trimesh.Trimesh], deviation: float, excess: float) -> tuple[Floats, ...]:
    """Corners of convex parts of solids."""
    return tuple(points for mesh in meshes for points in _convex(mesh, deviation, excess))


def _convex(mesh: trimesh.Trimesh, deviation: float, excess: float) -> list[Floats]:
    hull = trimesh.convex.convex_hull(mesh.vertices)
    if hull.volume <= (1 + CONVEX) * abs(mesh.volume):
        return [np.asarray(hull.vertices)]
    try:
        parts = decompose(mesh, MAX_PARTS, excess, deviation).parts
    except RejectedError:
        return [np.asarray(hull.vertices)]
    return [np.asarray(part.vertices) for part in parts]

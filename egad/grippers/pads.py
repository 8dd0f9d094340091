"""The pads of a hand with two moving fingers, and their way from open to closed."""

from collections.abc import Sequence
from itertools import product
from typing import NamedTuple

import mujoco
import numpy as np
import trimesh
from scipy.optimize import brentq
from scipy.spatial import ConvexHull, QhullError
from trimesh.intersections import slice_faces_plane

from egad._util.arrays import Floats
from egad.errors import UserError
from egad.geometry import RayCaster, joined, spread
from egad.grippers.description import shapes_of
from egad.grippers.fingers import Sides
from egad.grippers.jaw_solids import solids_of
from egad.grippers.mechanism import Mechanism, Placement, body_name, link_number

FACING = np.cos(np.radians(25.0))  # how far a face of a pad may turn away from the other finger
# metres that the foremost and the rearmost corner of a pad's face may lie behind the link's
PAD_DEPTH, PAD_TILT = 1e-3, 1.3e-3
MIN_OVERLAP = 5e-4  # metres of the pads
SPACING = 2e-3  # metres between points of a pad
UNEVEN = 5e-4  # metres by which the face of a pad may lie behind its foremost points
LEVELS = 65  # openings that are tabulated
MIN_OPENING, MAX_OPENING = 0.5e-3, 1.0  # metres


class Pads(NamedTuple):
    """The faces of the fingers that meet the object."""

    links: tuple[int, int]  # which link each is on
    centers: Floats  # (2, 3) their middles, in the frames of these links
    corners: tuple[Floats, Floats]  # of their faces, (n, 3) each, in these frames
    recess: tuple[float, float]  # as in `HandModel`


def find_pads(
    mechanism: Mechanism, closed: Floats, sides: Sides, links: Sequence[str] | None = None
) -> Pads:
    """The faces of both fingers that meet first when the hand closes; `UserError` if none do."""
    model = mechanism.model
    placement = mechanism.placement(closed)
    wanted = None if links is None else {link_number(model, name) for name in links}
    bodies = [sorted(side if wanted is None else side & wanted) for side in sides.links]
    fronts = [
        [(body, faces) for body in each if len(faces := _front(model, placement, body, ahead))]
        for each, ahead in zip(bodies, (sides.axis, -sides.axis), strict=True)
    ]
    facing = [pair for pair in product(*fronts) if _overlap(pair[0][1], pair[1][1], sides.axis)]
    if not facing:
        names = [", ".join(body_name(model, body) for body in each) or "(none)" for each in bodies]
        raise UserError(f"no face of the links {names[0]} is opposite one of the links {names[1]}")
    ends = [(pair[0][1] @ sides.axis).max() for pair in facing]
    gaps = [(pair[1][1] @ sides.axis).min() - end for pair, end in zip(facing, ends, strict=True)]
    pads = facing[int(np.argmin(gaps))]
    centers, corners, depths = [], [], []
    for (body, faces), ahead in zip(pads, (sides.axis, -sides.axis), strict=True):
        turn, place = placement.turns[body], placement.places[body]
        centers.append((_foremost_middle(faces, ahead) - place) @ turn)
        corners.append((faces.reshape(-1, 3) - place) @ turn)
        depths.append(_depths(model, body, (faces - place) @ turn, ahead @ turn))
    recess = (
        float((np.concatenate(depths) > UNEVEN).mean()),
        sum(float(each[np.isfinite(each)].max(initial=0.0)) for each in depths),
    )
    return Pads((pads[0][0], pads[1][0]), np.array(centers), (corners[0], corners[1]), recess)


def _front(model: mujoco.MjModel, placement: Placement, body: int, ahead: Floats) -> Floats:
    """What protrudes most ahead of the convex hull of a link, which bridges grooves: (n, 3, 3)."""
    shapes = shapes_of(model, body)
    if not shapes:
        return np.empty((0, 3, 3))
    points = np.concatenate(shapes) @ placement.turns[body].T + placement.places[body]
    try:
        hull = ConvexHull(points)
    except QhullError:  # it is flat
        return np.empty((0, 3, 3))
    looks, heights = hull.equations[:, :3] @ ahead, points @ ahead
    faces = points[hull.simplices[looks > FACING]]
    ends = np.sort(faces @ ahead, axis=1)
    foremost = ends[:, 0].max(initial=-np.inf)
    near = (ends[:, 2] > foremost - PAD_DEPTH) & (ends[:, 0] > foremost - PAD_TILT)
    if ends[near].max(initial=-np.inf) > heights.max() - PAD_DEPTH:
        return np.asarray(faces[near])
    faces = points[hull.simplices[looks > 0]]
    numbers = np.arange(3 * len(faces)).reshape(-1, 3)
    height = heights.max() - PAD_DEPTH
    points, kept, _ = slice_faces_plane(faces.reshape(-1, 3), numbers, ahead, height * ahead)
    return np.asarray(points[kept])


def _foremost_middle(faces: Floats, ahead: Floats) -> Floats:
    """The middle of triangles, where what protrudes most along their mean normal is."""
    normals = np.cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0])
    normals *= np.sign(normals @ ahead)[:, None]
    areas = np.linalg.norm(normals, axis=1)
    middle = np.average(faces.mean(axis=1), axis=0, weights=areas)
    mean = normals.sum(axis=0) / np.linalg.norm(normals.sum(axis=0))
    return np.asarray(middle + (faces @ mean - middle @ mean).max() * mean)


def _depths(model: mujoco.MjModel, body: int, faces: Floats, ahead: Floats) -> Floats:
    """How far a link lies behind points on triangles of its hull, metres; infinite in holes."""
    numbers = np.arange(3 * len(faces)).reshape(-1, 3)
    samples = spread(trimesh.Trimesh(faces.reshape(-1, 3), numbers), SPACING)
    outward = samples.normals * np.sign(samples.normals @ ahead)[:, None]
    link = RayCaster(joined(solids_of(model, body)))
    return np.asarray(
        link.first_hits(samples.points + UNEVEN * outward, -outward).distances - UNEVEN
    )


def _overlap(first: Floats, second: Floats, axis: Floats) -> bool:
    """Whether the rectangles around faces overlap, seen along an axis."""
    across = np.linalg.svd(axis[None])[2][1:]
    seen = [faces.reshape(-1, 3) @ across.T for faces in (first, second)]
    low = np.max([points.min(axis=0) for points in seen], axis=0)
    high = np.min([points.max(axis=0) for points in seen], axis=0)
    return bool(np.all(high - low > MIN_OVERLAP))


class Stroke(NamedTuple):
    """The way from closed to open."""

    positions: Floats  # (k, q) positions of all joints
    middles: Floats  # (k, 2, 3) middles of both pads, in the frame of the palm, metres
    pads: Pads  # the faces that meet


def find_stroke(mechanism: Mechanism, sides: Sides, links: Sequence[str] | None = None) -> Stroke:
    """The part of the way on which the pads come together until they meet, or `UserError`."""
    way = _follow(mechanism, sides, np.linspace(0, 1, LEVELS))
    pads = find_pads(mechanism, way[-1], sides, links)

    def gap(part: float) -> float:
        """Distance between the pads at a fraction of the way."""
        (middles,) = _middles(mechanism, _follow(mechanism, sides, np.array([part])), pads)
        return float((middles[1] - middles[0]) @ sides.axis)

    middles = _middles(mechanism, way, pads)
    names = " and ".join(body_name(mechanism.model, link) for link in pads.links)
    start, end = _useful((middles[:, 1] - middles[:, 0]) @ sides.axis, names)
    closed = end if gap(end) >= 0 else brentq(gap, start, end, xtol=1e-9)
    way = _follow(mechanism, sides, np.linspace(start, closed, LEVELS))[::-1]
    return Stroke(np.array(way), _middles(mechanism, way, pads), pads)


def _follow(mechanism: Mechanism, sides: Sides, parts: Floats) -> list[Floats]:
    """Positions of all joints at fractions of the driven way, from the middle outwards."""
    ranges = mechanism.ranges()
    start = np.where(sides.signs > 0, ranges[:, 0], ranges[:, 1])
    way = sides.signs * np.ptp(ranges, axis=1)
    found: dict[int, Floats] = {}
    half = int(np.abs(parts - 0.5).argmin())
    for numbers in (range(half, len(parts)), range(half, -1, -1)):
        near = mechanism.middle()
        for number in numbers:
            near = mechanism.follow(start + parts[number] * way, near)
            mechanism.check(near)
            found[number] = near
    return [found[number] for number in range(len(parts))]


def _middles(mechanism: Mechanism, way: Sequence[Floats], pads: Pads) -> Floats:
    """The middles of both pads in the frame of the palm, (k, 2, 3)."""
    pairs = list(zip(pads.links, pads.centers, strict=True))
    return np.array(
        [
            [turns[link] @ center + places[link] for link, center in pairs]
            for turns, places in map(mechanism.placement, way)
        ]
    )


def check_opening(opening: float, names: str, *, moves: bool = True) -> None:
    """Raise `UserError` if links open too little or too far, metres."""
    if opening < MIN_OPENING or not moves:
        raise UserError(f"its links {names} are at most {1000 * opening:.2g} mm apart")
    if opening > MAX_OPENING:
        raise UserError(
            f"its links {names} open {opening:.3g} m; limits of sliding joints are in metres"
        )


def _useful(gaps: Floats, names: str) -> tuple[float, float]:
    """Fractions of the way at which pads with these gaps, m, are open and meet; or `UserError`."""
    parts, widest = np.linspace(0, 1, len(gaps)), int(gaps.argmax())
    check_opening(max(float(gaps[widest]), 0.0), names)
    last = widest
    while last + 1 < len(gaps) and gaps[last + 1] < gaps[last] and gaps[last] > 0:
        last += 1
    return float(parts[widest]), float(parts[last])

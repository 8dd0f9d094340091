"""Where a moving jaw and a fixed one face each other, on solids of the shapes of their links."""

from contextlib import suppress
from typing import NamedTuple

import mujoco
import numpy as np
import trimesh
from scipy.spatial import QhullError

from egad._util.arrays import Flags, Floats
from egad.errors import RejectedError, UserError
from egad.geometry import RayCaster, spread, wind_outwards
from egad.grippers.description import shape_surfaces
from egad.grippers.fingers import snapped
from egad.grippers.mechanism import Mechanism
from egad.grippers.tree import body_name

POSITIONS = 17  # of the joint, at which faces are compared
SKIN = 1e-6  # metres in front of a face, where rays start
SPACING = 0.002  # metres between the points on a jaw that look out
FACING = np.cos(np.radians(30.0))  # how far two faces may turn away from each other
ALIKE = np.cos(np.radians(5.0))  # faces that turn less belong to one face, apart from steps
DISTAL = 0.4  # of the longest lever: whatever is nearer to the hinge is its bearing
ROUNDING = 0.04  # of directions that are compared
MIN_AREA = 2e-6  # square metres that face each other


class Facing(NamedTuple):
    """How two jaws face each other.

    Attributes:
        axis: Normal of the fixed jaw's inner face, towards the moving one, in the frame of the
            palm.
        normal: Normal of the moving jaw's inner face, in the frame of its link.
        closing: 1 if the jaw closes while the position of its joint grows, else -1.
        points: (n, 3) of the fixed jaw's face, in the frame of the palm, metres.
    """

    axis: Floats
    normal: Floats
    closing: float
    points: Floats


def solids_of(model: mujoco.MjModel, body: int) -> list[trimesh.Trimesh]:
    """The collision shapes of a link in its frame; open surfaces become their convex hull."""
    solids = []
    for points, faces in shape_surfaces(model, body):
        with suppress(QhullError):  # it is flat, and touches nothing
            try:
                mesh = trimesh.Trimesh(points, faces) if len(faces) else _hull(points)
                solids.append(wind_outwards(mesh))
            except RejectedError:
                solids.append(_hull(points))
    return solids


def find_facing(
    mechanism: Mechanism, body: int, moving: trimesh.Trimesh, fixed: RayCaster
) -> Facing:
    """The faces with which a jaw that moves closes against one that does not.

    Args:
        mechanism: The joints, of which one is driven.
        body: Number of the link that moves.
        moving: Its surface, in its frame.
        fixed: What does not move, in the frame of the palm.

    Raises:
        UserError: They never face each other.
    """
    samples = spread(moving, SPACING)
    counts = np.bincount(samples.faces, minlength=len(moving.faces))
    areas = (np.asarray(moving.area_faces) / np.maximum(counts, 1))[samples.faces]
    low, high = mechanism.ranges()[0]
    looks = [
        _looks(mechanism, body, float(position), samples.points, samples.normals, fixed)
        for position in np.linspace(low, high, POSITIONS)
    ]
    sums = [
        sum(float(areas[look.seen & (look.ways == way)].sum()) for look in looks) for way in (-1, 1)
    ]
    closing = float(np.sign(sums[1] - sums[0]))
    if max(sums) < MIN_AREA or closing == 0:
        raise UserError(
            f"its jaws never face each other: no face of the moving link "
            f"{body_name(mechanism.model, body)} closes against a fixed one"
        )
    chosen = [look.seen & (look.ways == closing) for look in looks]
    weights = np.concatenate([areas[rows] for rows in chosen])
    faces, points = (
        np.concatenate([each[rows] for each, rows in zip(column, chosen, strict=True)])
        for column in ([look.faces for look in looks], [look.points for look in looks])
    )
    own = np.concatenate([samples.normals[rows] for rows in chosen])
    axis, alike = _prevailing(faces, weights)
    normal, _ = _prevailing(own[alike], weights[alike])
    return Facing(axis, normal, closing, points[alike])


def _hull(points: Floats) -> trimesh.Trimesh:
    hull: trimesh.Trimesh = trimesh.convex.convex_hull(points)
    return hull


class _Looks(NamedTuple):
    """What points of a moving jaw see along their normals, (n,) each, and (n, 3)."""

    seen: Flags
    ways: Floats
    faces: Floats
    points: Floats


def _looks(
    mechanism: Mechanism,
    body: int,
    position: float,
    points: Floats,
    normals: Floats,
    fixed: RayCaster,
) -> _Looks:
    """Which points look at a face that looks back, and which way the joint moves them there."""
    positions = mechanism.follow(np.array([position]), mechanism.model.qpos0)
    turns, places = mechanism.placement(positions)
    there, ahead = points @ turns[body].T + places[body], normals @ turns[body].T
    velocities, levers = mechanism.velocities(positions, body, there)
    speeds = np.einsum("nk,nk->n", velocities, ahead)
    seen = np.abs(speeds) > FACING * np.linalg.norm(velocities, axis=1)
    seen &= levers >= DISTAL * levers.max()
    rows = np.flatnonzero(seen)
    hits = fixed.first_hits(there[rows] + SKIN * ahead[rows], np.ascontiguousarray(ahead[rows]))
    looks = np.einsum("nk,nk->n", hits.normals, ahead[rows])
    seen[rows] = hits.entering & (looks < -FACING)
    faces, met = np.zeros_like(points), there.copy()
    faces[rows] = hits.normals
    met[rows] += np.where(hits.entering, hits.distances, 0.0)[:, None] * ahead[rows]
    return _Looks(seen, np.sign(speeds), faces, met)


def _prevailing(normals: Floats, weights: Floats) -> tuple[Floats, Flags]:
    """The most common direction of some unit vectors, and which of them have it."""
    candidates = np.unique(np.round(normals / ROUNDING), axis=0)
    candidates /= np.linalg.norm(candidates, axis=1, keepdims=True)
    votes = [float(weights[normals @ each > ALIKE].sum()) for each in candidates]
    alike = normals @ candidates[int(np.argmax(votes))] > ALIKE
    mean = np.average(normals[alike], axis=0, weights=weights[alike])
    return snapped(mean / np.linalg.norm(mean)), alike

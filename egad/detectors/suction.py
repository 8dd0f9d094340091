"""suction-depth, suction-cloud: flat spots near the middle of what is seen, for a suction cup.

The rule that Dex-Net 3.0 (Mahler et al. 2018) compares with, planarity and centroid: the surface
within the ring must be flat, and the center of mass must lie close to the axis of the cup.
"""

from typing import NamedTuple

import numpy as np
from scipy.spatial import KDTree

from egad._util.arrays import Flags, Floats
from egad.detectors.base import SEARCH, Grasp, GraspPoses, best_poses, rank_grasps
from egad.detectors.camera import View
from egad.detectors.heightmap import heightmap_of
from egad.detectors.observation import PointCloud
from egad.detectors.restoration import restore
from egad.grasps import TABLE_CLEARANCE, hand_poses
from egad.grippers import Gripper, SuctionCup, cup_of

MAX_CANDIDATES = 500
RIM = 1.1  # times the radius of the ring: how far out the surface must be flat
FLAT = 0.1  # times that radius: deviation at which the quality is 0
TORQUE_SCALING = 50.0  # 1/m
MIN_POINTS = 9  # in a disc
SAMPLES = 50  # of a disc, each with a point nearby
NEIGHBORS, GAP = 4, 1.5  # nearby: times the median distance of the fourth neighbor
CLEARANCE = 0.002  # metres around the cup
UPWARD = 0.2  # the approach may point up by this sine


class _Discs(NamedTuple):
    """The surface around n points."""

    normals: Floats  # (n, 3) unit normals of the planes that fit best, of either sign
    # (n,) standard deviation, metres, of the distances from a plane within 1.1 times the ring;
    # infinite where little is seen
    deviations: Floats
    whole: Flags  # (n,) whether there are points all over the ring and inside it


def suction_depth(view: View, gripper: Gripper, _rng: np.random.Generator) -> list[Grasp]:
    """Flat and level spots in a depth image, near the middle of the object.

    Holes and noise of the image are removed first, as `egad.detectors.restore` does. A candidate
    is one of 500 pixels that see the object with points all around it and nothing above it where
    the cup comes down. The quality, from 0 to 1, is

        (1 - deviation / (0.1 radius)) / sqrt(1 + (50 / m * distance)^2)

    with the standard deviation of the heights within 1.1 times the ring, and the distance of the
    axis of the cup from the centroid of the volume below the visible surface.

    Raises:
        UserError: The gripper has jaws.
    """
    cup = cup_of(gripper, "the detector suction-depth")
    view = restore(view)
    heightmap = heightmap_of(view)
    points = view.points().reshape(-1, 3)
    standing = points[points[:, 2] > TABLE_CLEARANCE]  # leaves out those that saw nothing
    if heightmap is None or not len(standing):
        return []
    chosen = np.linspace(0, len(standing) - 1, min(len(standing), MAX_CANDIDATES)).astype(np.int64)
    centers = standing[chosen]
    discs = _fit_discs(standing, centers, cup, np.array([0.0, 0.0, 1.0]))
    lever = np.linalg.norm(centers[:, :2] - heightmap.centroid()[:2], axis=1)
    quality = _quality(discs, lever, cup)
    good = np.flatnonzero(discs.whole & (quality > 0))
    down = np.array([0.0, 0.0, -1.0])
    good = good[[not _blocked(standing, centers[each], down, cup) for each in good]]
    axis, width = np.tile([1.0, 0.0], (len(good), 1)), np.zeros(len(good))
    depth = np.minimum(SEARCH, centers[good, 2])
    return rank_grasps(centers[good], axis, width, depth, quality[good])


def suction_cloud(cloud: PointCloud, gripper: Gripper, rng: np.random.Generator) -> GraspPoses:
    """Flat spots of a point cloud from any direction, near the middle of what is there.

    A candidate is one of 500 points with others all around it. The cup comes along the normal of
    the plane that fits best, not from below, and meets neither another point nor the table. The
    score, from 0 to 1, is that of `suction_depth` times (1 - slope) / 2: the deviation is of the
    distances from that plane, the centroid that of the points nearer than the opening of the
    gripper, for which objects are scaled; the slope is the third coordinate of the approach, -1
    straight down. UserError if the gripper has jaws.
    """
    cup = cup_of(gripper, "the detector suction-cloud")
    chosen = np.sort(rng.permutation(len(cloud.points))[:MAX_CANDIDATES])
    centers = cloud.points[chosen]
    discs = _fit_discs(cloud.points, centers, cup)
    inward = np.sign(np.einsum("ij,ij->i", discs.normals, cloud.normals[chosen]))
    approaches = -inward[:, None] * discs.normals
    lever = _levers(cloud.points, centers, approaches, gripper.opening)
    scores = _quality(discs, lever, cup) * (1 - approaches[:, 2]) / 2
    good = np.flatnonzero(discs.whole & (scores > 0) & (approaches[:, 2] <= UPWARD))
    good = good[[_is_free(cloud.points, centers[n], approaches[n], cup) for n in good]]
    poses = hand_poses(centers[good], _across(approaches[good]), approaches[good])
    return best_poses(GraspPoses(poses, np.zeros(len(good)), scores[good]))


def _fit_discs(
    points: Floats, centers: Floats, cup: SuctionCup, across: Floats | None = None
) -> _Discs:
    """The surface around (n, 3) centers, by planes with the normal `across`, or those that fit."""
    count = len(centers)
    normals, deviations, whole = np.zeros((count, 3)), np.full(count, np.inf), np.zeros(count, bool)
    if len(points) < MIN_POINTS:
        return _Discs(normals, deviations, whole)
    tree = KDTree(points)
    gap = GAP * float(np.median(tree.query(points, [NEIGHBORS + 1])[0]))
    samples = (cup.radius + gap) * _sunflower()
    found = tree.query_ball_point(centers, RIM * cup.radius)
    for number, (center, numbers) in enumerate(zip(centers, found, strict=True)):
        near = points[numbers]
        if len(near) < MIN_POINTS:
            continue
        offsets = near - near.mean(axis=0)
        squares, axes = np.linalg.eigh(offsets.T @ offsets / len(near))
        normals[number] = axes[:, 0]
        deviations[number] = (
            np.sqrt(max(squares[0], 0.0)) if across is None else (near @ across).std()
        )
        if deviations[number] < FLAT * cup.radius:
            wider = points[tree.query_ball_point(center, cup.radius + 2 * gap)]
            seen = KDTree((wider - center) @ axes[:, 1:])
            whole[number] = bool(np.max(seen.query(samples)[0]) <= gap)
    return _Discs(normals, deviations, whole)


def _sunflower() -> Floats:
    """Points all over a disc of radius 1, some of them on its rim, (SAMPLES, 2)."""
    number = np.arange(1, SAMPLES + 1)
    rim = round(2 * np.sqrt(SAMPLES))
    radii = np.sqrt(np.minimum((number - 0.5) / (SAMPLES - (rim + 1) / 2), 1.0))
    angles = np.pi * (3 - np.sqrt(5)) * number
    return np.stack([radii * np.cos(angles), radii * np.sin(angles)], axis=1)


def _quality(discs: _Discs, lever: Floats, cup: SuctionCup) -> Floats:
    """From 0 to 1, (n,); see `suction_depth`."""
    flat = np.maximum(1 - discs.deviations / (FLAT * cup.radius), 0.0)
    quality: Floats = flat / np.sqrt(1 + (TORQUE_SCALING * lever) ** 2)
    return quality


def _levers(points: Floats, centers: Floats, approaches: Floats, radius: float) -> Floats:
    """Distances of lines from the centroids of the points near their origins, (n,), metres."""
    if not len(centers):
        return np.zeros(0)
    found = KDTree(points).query_ball_point(centers, radius)
    away = np.array([points[numbers].mean(axis=0) for numbers in found]) - centers
    return np.asarray(np.linalg.norm(np.cross(away, approaches), axis=1))


def _blocked(points: Floats, center: Floats, approach: Floats, cup: SuctionCup) -> bool:
    """Whether a point is where cup and stem are when the ring is at a center, or on their way."""
    offsets = points - center
    behind = -offsets @ approach
    aside = np.linalg.norm(offsets + behind[:, None] * approach, axis=1)
    wide = max(cup.radius, cup.stem_radius) + CLEARANCE
    return bool(((behind > cup.radius) & (aside < wide)).any())


def _is_free(points: Floats, center: Floats, approach: Floats, cup: SuctionCup) -> bool:
    """Whether neither the table nor a point is where cup and stem are, or on their way."""
    level = np.sqrt(max(1 - approach[2] ** 2, 0.0))
    back = (cup.height + cup.stem_length) * max(approach[2], 0.0)
    lowest = center[2] - back - max(cup.radius, cup.stem_radius) * level
    return bool(lowest >= TABLE_CLEARANCE and not _blocked(points, center, approach, cup))


def _across(approaches: Floats) -> Floats:
    """Unit vectors at right angles to approaches, (n, 3)."""
    helper = np.where(np.abs(approaches[:, 2:]) < 0.9, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]])
    found = np.cross(approaches, helper)
    return np.asarray(found / np.linalg.norm(found, axis=1, keepdims=True))

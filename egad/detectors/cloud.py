"""antipodal-cloud: grasps between opposing points of a point cloud, from any direction."""

from typing import NamedTuple

import numpy as np

from egad._util.arrays import Floats, Ints
from egad.detectors.base import GraspPoses, best_poses
from egad.detectors.collision import in_collision
from egad.detectors.observation import PointCloud
from egad.grasps import hand_poses, roomy
from egad.grippers import Gripper, check_jaws

MAX_POINTS = 800  # that can be contacts
MAX_PAIRS = 1000  # that are rated
MAX_CANDIDATES = 60  # for which approaches are tried
MAX_OBSTACLES = 3000  # points that the hand must not touch
APPROACHES = 16  # around the closing axis
UPWARD = 0.2  # sine of the angle by which the approach may point up
MIN_CLEARANCE = 0.002  # on each side of the object
TORQUE_SCALING = 100.0  # 1/m


class _PointPairs(NamedTuple):
    """Candidates: two opposing points each."""

    middle: Floats  # (n, 3)
    axis: Floats  # (n, 3) unit vectors from the first point to the second
    distance: Floats  # (n,)
    squareness: Floats  # (n,) smaller cos^2 of the angles between axis and normals


def antipodal_cloud(cloud: PointCloud, gripper: Gripper, rng: np.random.Generator) -> GraspPoses:
    """Grasps between opposing points of a point cloud (ours).

    Two points are a candidate if the line between them lies in the friction cones of both and the
    hand opens wide enough. Of the approaches around this line, those are kept that do not come from
    below and on which the hand touches neither another point nor the table. The score, from 0 to 1,
    is

        cos^2(angle) / sqrt(1 + (100 / m * distance)^2) * (1 - slope) / 2,

    the closed form of the Ferrari-Canny quality for small angles, estimated from the cloud. The
    angle is the larger one between the line and the normals. The distance is that of the line from
    the centroid of the points no further away than the opening of the hand. The slope is the third
    coordinate of the approach, -1 straight down.
    """
    check_jaws(gripper, "the detector antipodal-cloud")
    obstacles = cloud.points[_chosen(len(cloud.points), MAX_OBSTACLES, rng)]
    pairs = _pairs(cloud, gripper, rng)
    quality = pairs.squareness / _moment(pairs, obstacles, gripper.opening)
    best = np.argsort(-quality, kind="stable")[:MAX_CANDIDATES]
    pairs, quality = _PointPairs(*(values[best] for values in pairs)), quality[best]
    widths = roomy(pairs.distance, gripper)
    approaches = _around(pairs.axis)
    count = len(pairs.axis)
    poses = hand_poses(
        np.repeat(pairs.middle, APPROACHES, axis=0),
        np.repeat(pairs.axis, APPROACHES, axis=0),
        approaches.reshape(-1, 3),
    )
    slope = approaches[:, :, 2]
    scores = quality[:, None] * (1 - slope) / 2
    blocked = (slope > UPWARD).ravel()
    blocked[~blocked] = in_collision(
        poses[~blocked], np.repeat(widths, APPROACHES)[~blocked], obstacles, gripper
    )
    scores[blocked.reshape(count, APPROACHES)] = -1.0
    turn = scores.argmax(axis=1)
    each = np.arange(count)
    found = GraspPoses(
        poses.reshape(count, APPROACHES, 4, 4)[each, turn], widths, scores[each, turn]
    )
    return best_poses(GraspPoses(*(values[found.scores > 0] for values in found)))


def _chosen(count: int, most: int, rng: np.random.Generator) -> Ints:
    """Some of the numbers below `count`, ascending."""
    return np.sort(rng.permutation(count)[:most])


def _pairs(cloud: PointCloud, gripper: Gripper, rng: np.random.Generator) -> _PointPairs:
    """Pairs of some points that oppose each other within friction cones and opening."""
    chosen = _chosen(len(cloud.points), MAX_POINTS, rng)
    points, normals = cloud.points[chosen], cloud.normals[chosen]
    cone = np.cos(np.arctan(gripper.pad.friction))
    # If a line lies in both cones, the normals are opposite to within twice the angle of a cone.
    first, second = np.nonzero(np.triu(normals @ normals.T < 1 - 2 * cone**2, 1))
    apart = points[second] - points[first]
    distance = np.linalg.norm(apart, axis=1)
    axis = apart / np.maximum(distance, 1e-12)[:, None]
    cosines = np.minimum(
        -np.einsum("ij,ij->i", axis, normals[first]), np.einsum("ij,ij->i", axis, normals[second])
    )
    widest = gripper.opening - 2 * MIN_CLEARANCE
    fits = np.flatnonzero((cosines >= cone) & (distance <= widest))
    fits = fits[_chosen(len(fits), MAX_PAIRS, rng)]
    middle = (points[first[fits]] + points[second[fits]]) / 2
    return _PointPairs(middle, axis[fits], distance[fits], cosines[fits] ** 2)


def _moment(pairs: _PointPairs, points: Floats, radius: float) -> Floats:
    """The factor by which the lever of the weight lowers the quality of pairs, (n,), at least 1."""
    offsets = points[None] - pairs.middle[:, None]
    near = (offsets**2).sum(axis=2) <= radius**2
    away = (offsets * near[:, :, None]).sum(axis=1) / np.maximum(near.sum(axis=1), 1)[:, None]
    across = away - np.einsum("ij,ij->i", away, pairs.axis)[:, None] * pairs.axis
    moment: Floats = np.sqrt(1 + TORQUE_SCALING**2 * (across**2).sum(axis=1))
    return moment


def _around(axes: Floats) -> Floats:
    """Unit vectors at right angles to axes (n, 3), evenly around them: (n, APPROACHES, 3)."""
    helper = np.where(np.abs(axes[:, 2:]) < 0.9, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]])
    first = np.cross(axes, helper)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = np.cross(axes, first)
    turns = 2 * np.pi * np.arange(APPROACHES) / APPROACHES
    ways: Floats = (
        np.cos(turns)[None, :, None] * first[:, None]
        + np.sin(turns)[None, :, None] * second[:, None]
    )
    return ways

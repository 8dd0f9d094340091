"""antipodal-depth: grasps between opposing edges of a depth image."""

from typing import NamedTuple

import numpy as np
from scipy import ndimage

from egad._util.arrays import Floats
from egad.detectors.base import MIN_DEPTH, Grasp, depth_weight, rank_grasps
from egad.detectors.camera import View, Window
from egad.detectors.heightmap import Heightmap, heightmap_of, min_fingertip_height, window_of
from egad.detectors.restoration import restore
from egad.grasps import TABLE_CLEARANCE, roomy
from egad.grippers import Gripper, check_jaws

MAX_EDGES = 400
MAX_CANDIDATES = 400
MIN_CLEARANCE = 0.002  # on each side of the object
TORQUE_SCALING = 100.0  # 1/m
BLUR = 1.5  # pixels
NEARLY = 1e-6
MARGIN = 9  # pixels; blurring reaches 6 of them, and each of two gradients one more


class _Edges(NamedTuple):
    """Edges where the surface falls off too steeply to slip out between two pads."""

    points: Floats  # (n, 3) world
    outward: Floats  # (n, 2) unit vectors, towards the lower side


class _EdgePairs(NamedTuple):
    """Candidates: two opposing edges each."""

    middle: Floats  # (n, 2)
    axis: Floats  # (n, 2) unit vectors from the first edge to the second
    distance: Floats  # (n,)
    top: Floats  # (n,) height of the lower of the two edges
    squareness: Floats  # (n,) smaller cos^2 of the angles between axis and edge normals


def antipodal_depth(view: View, gripper: Gripper, _rng: np.random.Generator) -> list[Grasp]:
    """Grasps between opposing edges of a depth image (ours, after Dex-Net's image sampler).

    An edge is where the surface falls by at least 1 / friction: less steep sides slip out between
    vertical pads. Two edges are a candidate if the line between them lies in the friction cones
    of both (in the plane), and the hand opens wide enough. The hand goes as deep as table,
    neighboring surface and palm allow. Holes and noise of the image are removed first, as
    `egad.detectors.restore` does. The quality, from 0 to 1, is

        cos^2(angle) / sqrt(1 + (100 / m * distance)^2) * min(penetration / 20 mm, 1),

    the closed form of the Ferrari-Canny quality for small angles, estimated from the image. The
    angle is the larger one between the line and the edge normals. The distance is that of the line
    from the centroid of the volume below the visible surface. The penetration is how far the pads
    reach below the lower edge.
    """
    check_jaws(gripper, "the detector antipodal-depth")
    view = restore(view)
    window = _uneven(view, gripper.pad.friction)
    heightmap = heightmap_of(view, window)
    if heightmap is None:
        return []
    pairs = _pairs(_edges(view, window, gripper.pad.friction), gripper)
    if len(pairs.top) == 0:
        return []
    centroid = heightmap.centroid()
    # Probing the space for the hand is costly: first assume that the palm stays above everything.
    tip = max(heightmap.heights.max() - gripper.finger_length, 0.0) + TABLE_CLEARANCE
    hopeful = np.argsort(-_quality(pairs, centroid, tip), kind="stable")[:MAX_CANDIDATES]
    return _grasps(_EdgePairs(*(values[hopeful] for values in pairs)), heightmap, centroid, gripper)


def _edges(view: View, window: Window, friction: float) -> _Edges:
    """Pixels on steep falls, but not at their feet, thinned to at most `MAX_EDGES`."""
    points = view.points(window)
    heights = np.nan_to_num(points[..., 2])
    pitch = np.nan_to_num(view.depth[window], nan=np.inf) / view.intrinsics.focal
    steep = np.hypot(*np.gradient(heights)) >= pitch / friction
    rises = ndimage.maximum_filter(heights, 3) - heights
    drops = heights - ndimage.minimum_filter(heights, 3)
    rows, columns = np.nonzero(steep & (2 * drops > rises))
    chosen = np.linspace(0, len(rows) - 1, min(len(rows), MAX_EDGES)).astype(np.int64)
    rows, columns = rows[chosen], columns[chosen]
    # Steps of the pixel grid turn the gradient by up to 45 degrees; blurring evens them out.
    blurred: Floats = ndimage.gaussian_filter(heights, BLUR)
    fall_v, fall_u = np.gradient(-blurred)
    fall = np.stack([fall_u, fall_v], axis=-1)[rows, columns]
    outward = fall @ view.pose[:2, :2].T
    lengths = np.linalg.norm(outward, axis=1, keepdims=True)
    return _Edges(points[rows, columns], outward / np.maximum(lengths, 1e-12))


def _uneven(view: View, friction: float) -> Window:
    """The part of an image with all steep pixels, and what blurring mixes in around them."""
    pitch = float(np.nan_to_num(view.depth, nan=np.inf).min()) / view.intrinsics.focal
    level = min(pitch / friction / 4, TABLE_CLEARANCE)
    return window_of(np.abs(view.heights()) > level, MARGIN)


def _pairs(edges: _Edges, gripper: Gripper) -> _EdgePairs:
    """All pairs of edges that oppose each other within friction cones and opening."""
    cone = np.cos(np.arctan(gripper.pad.friction))
    # If a line lies in both cones, the normals are opposite to within twice the angle of a cone.
    opposed = edges.outward @ edges.outward.T < NEARLY - (2 * cone**2 - 1)
    first, second = np.nonzero(np.triu(opposed, 1))
    apart = edges.points[second, :2] - edges.points[first, :2]
    distance = np.sqrt(apart[:, 0] ** 2 + apart[:, 1] ** 2)
    near = np.flatnonzero(distance <= gripper.opening - 2 * MIN_CLEARANCE)
    first, second, distance = first[near], second[near], distance[near]
    axis = apart[near] / np.maximum(distance, 1e-12)[:, None]
    cosines = np.minimum(
        -np.einsum("ij,ij->i", axis, edges.outward[first]),
        np.einsum("ij,ij->i", axis, edges.outward[second]),
    )
    fits = np.flatnonzero(cosines >= cone)
    first, second = first[fits], second[fits]
    return _EdgePairs(
        middle=(edges.points[first, :2] + edges.points[second, :2]) / 2,
        axis=axis[fits],
        distance=distance[fits],
        top=np.minimum(edges.points[first, 2], edges.points[second, 2]),
        squareness=cosines[fits] ** 2,
    )


def _quality(pairs: _EdgePairs, centroid: Floats, tip: Floats | float) -> Floats:
    """The quality of pairs for fingertips at some height, (n,); see `antipodal_depth`."""
    penetration = pairs.top - tip
    away = centroid[:2] - pairs.middle
    across = away[:, 0] * pairs.axis[:, 1] - away[:, 1] * pairs.axis[:, 0]
    above = tip + penetration / 2 - centroid[2]
    moment = np.sqrt(1 + TORQUE_SCALING**2 * (across**2 + above**2))
    quality: Floats = pairs.squareness / moment * depth_weight(penetration)
    return quality


def _grasps(
    pairs: _EdgePairs, heightmap: Heightmap, centroid: Floats, gripper: Gripper
) -> list[Grasp]:
    """Candidates for which the hand has space, with their depths and qualities."""
    width = roomy(pairs.distance, gripper)
    tip = min_fingertip_height(pairs.middle, pairs.axis, width, heightmap, gripper)
    penetration = pairs.top - tip
    level = tip + penetration / 2
    quality = _quality(pairs, centroid, tip)
    center = np.column_stack([pairs.middle, level])
    columns = (center, pairs.axis, width, penetration / 2, quality)
    return rank_grasps(*(values[penetration >= MIN_DEPTH] for values in columns))

"""What cameras around a table see of a scene: depth images, their point cloud and their TSDF."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from egad._util.arrays import Floats
from egad.detectors.camera import DepthCamera, Intrinsics, View, object_mask
from egad.detectors.tsdf import Tsdf, fuse

BELOW = 0.05  # metres; the cube of a TSDF begins this far below the table
TSDF_RESOLUTION, CLOUD_RESOLUTION = 40, 120  # voxels along a side
TABLE_NOISE = 0.004  # metres; what is lower is taken for the table


class PointCloud(NamedTuple):
    """Points of the surface that cameras see, (n, 3) in metres, and outward unit normals, (n, 3).

    The table is at height 0. What is lower than 4 mm is left out, as sensor noise lifts the table.
    """

    points: Floats
    normals: Floats


@dataclass(frozen=True)
class Observation:
    """A scene on a table at height 0, as cameras see it.

    Attributes:
        view: A depth image straight from above.
        views: Depth images from all around.
        side: Side of the workspace, a square around the origin, metres.
        point_sigma: Standard deviation of noise on each coordinate of the cloud, metres.
        point_seed: Seed of that noise.
    """

    view: View
    views: tuple[View, ...]
    side: float
    point_sigma: float = 0.0
    point_seed: int = 0

    @cached_property
    def tsdf(self) -> Tsdf:
        """The views fused into 40 x 40 x 40 voxels: a cube that begins 5 cm below the table."""
        return self.fuse_views(TSDF_RESOLUTION)

    @cached_property
    def cloud(self) -> PointCloud:
        """The surface of the views fused into 120 x 120 x 120 voxels, from 4 mm above the table."""
        fine = self.fuse_views(CLOUD_RESOLUTION)
        points, normals = fine.surface()
        if self.point_sigma:
            rng = np.random.default_rng(self.point_seed)
            points = points + rng.normal(0.0, self.point_sigma, points.shape)
        standing = points[:, 2] > TABLE_NOISE
        return PointCloud(points[standing], normals[standing])

    @cached_property
    def point_objects(self) -> NDArray[np.uint8]:
        """The object of each point, (n,), 0 for the table; ValueError without masks."""
        if not all(view.mask.size for view in self.views):
            raise ValueError("views without masks do not tell objects apart")
        standing = [view.heights() > TABLE_NOISE for view in self.views]
        pairs = list(zip(self.views, standing, strict=True))
        seen = np.concatenate([view.points()[high] for view, high in pairs])
        # Without any points, the tree answers 0, which is the index of that last number.
        objects = np.append(np.concatenate([view.mask[high] for view, high in pairs]), np.uint8(0))
        nearest: NDArray[np.uint8] = objects[KDTree(seen).query(self.cloud.points)[1]]
        return nearest

    @cached_property
    def object_clouds(self) -> tuple[PointCloud, ...]:
        """The points of `cloud` of each object that has any; ValueError for views without masks."""
        points, normals = self.cloud
        each = (self.point_objects == k for k in np.unique(self.point_objects) if k)
        return tuple(PointCloud(points[own], normals[own]) for own in each)

    def fuse_views(self, resolution: int) -> Tsdf:
        """The views fused into a cube of `resolution` voxels along a side."""
        corner = np.array([-self.side / 2, -self.side / 2, -BELOW])
        return fuse(self.views, corner, self.side, resolution)


def look_at(eye: Floats, target: Floats) -> Floats:
    """The pose, (4, 4), of an upright camera at a point that looks at another, not vertically."""
    forward = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    pose = np.eye(4)
    pose[:3, :3] = np.stack([right, np.cross(forward, right), forward], axis=1)
    pose[:3, 3] = eye
    return pose


def cameras_around(
    target: Floats, count: int, distance: float, tilt: float, azimuth: float = 0.0
) -> list[Floats]:
    """Poses, (4, 4) each, of tilted cameras that look at a point from around it; m and radians."""
    angles = azimuth + 2 * np.pi * np.arange(count) / count
    ways = [np.array([np.cos(a), np.sin(a), 0.0]) * np.sin(tilt) for a in angles]
    up = np.array([0.0, 0.0, np.cos(tilt)])
    return [look_at(target + distance * (way + up), target) for way in ways]


def render_scene(
    cameras: Sequence[DepthCamera], matrices: Sequence[Floats], intrinsics: Intrinsics, pose: Floats
) -> View:
    """A depth image of several objects on the table; matrices and pose, (4, 4), to the world."""
    views = [
        camera.render(matrix, intrinsics, pose)
        for camera, matrix in zip(cameras, matrices, strict=True)
    ]
    return overlaid(views)


def overlaid(views: Sequence[View]) -> View:
    """What a camera sees of all objects, given its views of each one: the nearest depths."""
    whole = replace(views[0], depth=np.fmin.reduce([view.depth for view in views]))
    seen, mask = object_mask(whole), np.zeros(whole.depth.shape, dtype=np.uint8)
    for number, view in enumerate(views, start=1):
        mask[seen & (view.depth == whole.depth)] = number
    return replace(whole, mask=mask)

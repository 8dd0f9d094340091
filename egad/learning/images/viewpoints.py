"""A table in a random pose, with a random camera above it."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from egad._util.arrays import Floats, Ints
from egad.detectors import Intrinsics
from egad.detectors.camera import LOOKING_DOWN
from egad.geometry import StablePose
from egad.learning.images.parameters import Camera


class CameraScene(NamedTuple):
    """Transforms to the world, (4, 4): of the table (z = 0), and of a camera, z forward."""

    matrix: Floats
    intrinsics: Intrinsics
    camera: Floats


def sample_object_poses(poses: Sequence[StablePose], count: int, rng: np.random.Generator) -> Ints:
    """Ascending indices of the poses of `count` images, evenly spaced in probability."""
    ends = np.cumsum([pose.probability for pose in poses])
    levels = (rng.random() + np.arange(count)) / max(count, 1) * ends[-1]
    return np.asarray(np.minimum(np.searchsorted(ends, levels, side="right"), len(poses) - 1))


def sample_scene(center: Floats, settings: Camera, rng: np.random.Generator) -> CameraScene:
    """A table turned and shifted (Mahler et al. 2017), and a camera that sees `center`, (3,)."""
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_rotvec([0, 0, rng.uniform(0, 2 * np.pi)]).as_matrix()
    matrix[:2, 3] = rng.uniform(-settings.shift, settings.shift, 2)
    camera = _camera(settings, rng)
    width, height = settings.image
    middle = np.array([(width - 1) / 2, (height - 1) / 2])
    intrinsics = Intrinsics(width, height, rng.uniform(*settings.focal), (middle[0], middle[1]))
    if settings.centered:
        seen = np.linalg.inv(camera) @ matrix @ np.append(center, 1)
        u, v = 2 * middle - intrinsics.pixels(seen[None, :3])[0]
        intrinsics = intrinsics._replace(center=(float(u), float(v)))
    return CameraScene(matrix, intrinsics, camera)


def _camera(settings: Camera, rng: np.random.Generator) -> Floats:
    """A camera on a sphere around the origin; upright, x is to the right, see `camera_above`."""
    distance = rng.uniform(*settings.distance)
    tilt, roll = np.radians([rng.uniform(*settings.tilt), rng.uniform(*settings.roll)])
    towards = rng.uniform(0, 2 * np.pi)
    lean = Rotation.from_rotvec(tilt * np.array([np.cos(towards), np.sin(towards), 0]))
    pose = np.eye(4)
    turn = Rotation.from_rotvec([0, 0, roll]).as_matrix()
    pose[:3, :3] = lean.as_matrix() @ LOOKING_DOWN @ turn
    pose[:3, 3] = -distance * pose[:3, 2]
    return pose

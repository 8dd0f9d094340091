"""Depth images by ray casting: exact, metric, and without a window."""

from dataclasses import dataclass, field
from functools import lru_cache
from typing import NamedTuple, Self

import numpy as np
import trimesh
from numpy.typing import NDArray

from egad._util.arrays import Flags, Floats
from egad.geometry import TriangleScene

Depth = NDArray[np.float32]
Window = tuple[slice, slice]

LOOKING_DOWN = np.diag([1.0, -1.0, -1.0])
WHOLE = (slice(None), slice(None))


class Intrinsics(NamedTuple):
    """A pinhole camera; pixel (0, 0) has its center at u = v = 0.

    Attributes:
        width: Pixels.
        height: Pixels.
        focal: Focal length, pixels, in both directions.
        center: Where the optical axis meets the image, pixels (u, v).
    """

    width: int
    height: int
    focal: float
    center: tuple[float, float]

    @classmethod
    def spanning(cls, width: int, height: int, field_of_view: float) -> Self:
        """An image of the given size in pixels, whose width spans an angle in degrees."""
        focal = width / 2 / float(np.tan(np.radians(field_of_view) / 2))
        return cls(width, height, focal, ((width - 1) / 2, (height - 1) / 2))

    def sees(self, points: Floats) -> bool:
        """Whether all of some points (n, 3), in the frame of the camera, are in the image."""
        if points[:, 2].min() <= 0:
            return False
        pixels = self.pixels(points)
        size = (self.width, self.height)
        return bool(((pixels >= -0.5) & (pixels <= np.array(size) - 0.5)).all())

    def pixels(self, points: Floats) -> Floats:
        """Where points (n, 3) in front of it, in its frame, are in the image, (n, 2) u and v."""
        seen: Floats = points[:, :2] / points[:, 2:] * self.focal + self.center
        return seen

    def slopes(self) -> tuple[Floats, Floats]:
        """The x at depth 1 for each column of pixels, and the y for each row."""
        u, v = np.arange(self.width), np.arange(self.height)
        x, y = (u - self.center[0]) / self.focal, (v - self.center[1]) / self.focal
        return np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64)

    def rays(self, window: Window = WHOLE) -> Floats:
        """For each pixel the point that it sees at depth 1, camera frame, (height, width, 3)."""
        x, y = self.slopes()
        x, y = np.broadcast_arrays(x[None, window[1]], y[window[0], None])
        return np.stack([x, y, np.ones_like(x)], axis=-1)


@dataclass(frozen=True)
class View:
    """A depth image and the camera that took it.

    Attributes:
        depth: Metres along the optical axis, (height, width); NaN where it is missing.
        intrinsics: The camera.
        pose: (4, 4) transform from the camera (x right, y down, z forward) to the world.
        mask: k for pixels that see the k-th object of a scene, from 1; else 0, (height, width).
            Empty, (0, 0), if that is not known.
    """

    depth: Depth
    intrinsics: Intrinsics
    pose: Floats
    mask: NDArray[np.uint8] = field(default_factory=lambda: np.zeros((0, 0), np.uint8))

    def points(self, window: Window = WHOLE) -> Floats:
        """The point that each pixel sees, in the world, metres, (height, width, 3)."""
        camera = self.intrinsics.rays(window) * self.depth[window][..., None]
        world: Floats = camera @ self.pose[:3, :3].T + self.pose[:3, 3]
        return world

    def heights(self) -> Floats:
        """The third coordinate of `points`, with less work, (height, width)."""
        x, y = self.intrinsics.slopes()
        across, down, forward = self.pose[2, :3]
        slopes = (y * down + forward)[:, None] + x * across
        heights: Floats = slopes * self.depth + self.pose[2, 3]
        return heights


def camera_above(height: float) -> Floats:
    """The pose of a camera that looks straight down at the origin, x to the right, (4, 4)."""
    pose = np.eye(4)
    pose[:3, :3] = LOOKING_DOWN
    pose[2, 3] = height
    return pose


class DepthCamera:
    """Takes depth images of one object on the table at height 0."""

    def __init__(self, mesh: trimesh.Trimesh) -> None:
        """Prepare the ray casting of an object, in metres."""
        self._vertices = np.asarray(mesh.vertices, dtype=np.float64)
        self._scene = TriangleScene(self._vertices, mesh.faces)

    def render(self, matrix: Floats, intrinsics: Intrinsics, pose: Floats) -> View:
        """A depth image, from the (4, 4) transforms of the object and the camera to the world."""
        depth = _known_table(intrinsics, pose.tobytes()).copy()
        to_object = np.linalg.inv(matrix) @ pose
        window = self._window(to_object, intrinsics)
        seen = intrinsics.rays(window)
        directions = (seen.reshape(-1, 3) @ to_object[:3, :3].T).astype(np.float32)
        origins = np.broadcast_to(to_object[:3, 3].astype(np.float32), directions.shape)
        # Each direction reaches depth 1, so distances along them are depths.
        distances = self._scene.distances(origins, directions).reshape(seen.shape[:2])
        distances[np.isinf(distances)] = np.nan
        depth[window] = np.fmin(depth[window], distances)
        return View(depth, intrinsics, pose)

    def _window(self, to_object: Floats, intrinsics: Intrinsics) -> Window:
        """The rows and columns that can see the object; all if some of it is not in front."""
        to_camera = np.linalg.inv(to_object)
        seen = self._vertices @ to_camera[:3, :3].T + to_camera[:3, 3]
        if seen[:, 2].min() <= 0:
            return WHOLE
        pixels = intrinsics.pixels(seen)
        low = np.maximum(np.floor(pixels.min(axis=0)).astype(int), 0)
        high = np.maximum(np.ceil(pixels.max(axis=0)).astype(int) + 1, 0)
        return slice(low[1], high[1]), slice(low[0], high[0])


def table_depth(intrinsics: Intrinsics, pose: Floats) -> Depth:
    """Depth of the plane z = 0 in each pixel, (height, width); not a number above the horizon."""
    x, y = intrinsics.slopes()
    across, down, forward = -pose[2, :3]
    sinking = (y * down + forward)[:, None] + x * across
    below = sinking > 0
    depth = np.where(below, pose[2, 3] / np.where(below, sinking, 1.0), np.nan)
    return depth.astype(np.float32)


@lru_cache(maxsize=1)
def _known_table(intrinsics: Intrinsics, pose: bytes) -> Depth:
    """`table_depth` of a camera that has not moved since its last image."""
    return table_depth(intrinsics, np.frombuffer(pose).reshape(4, 4))


def object_mask(view: View) -> Flags:
    """Which pixels of a camera's view see the object, (height, width)."""
    table = _known_table(view.intrinsics, view.pose.tobytes())
    return np.asarray(np.isfinite(view.depth) & ~(view.depth >= table))

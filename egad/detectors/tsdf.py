"""Depth images fused into a truncated signed distance field, and the surface in it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from skimage.measure import marching_cubes

from egad._util.arrays import Floats, Singles
from egad._util.kernels import kernel
from egad.detectors.camera import View

TRUNCATION = 4.0  # voxels


@dataclass(frozen=True)
class Tsdf:
    """Signed distances to the nearest surface in a cube, positive in free space."""

    # at the centers of the voxels, in units of the truncation, from -1 to 1, axis order x, y, z,
    # (n, n, n); 0 where no camera sees
    distances: Singles
    weights: Singles  # number of cameras that see the voxel or what is just before it, (n, n, n)
    corner: Floats  # corner of the cube with the least coordinates, (3,), metres
    voxel: float  # side of a voxel, metres
    truncation: float  # metres

    def surface(self) -> tuple[Floats, Floats]:
        """Points and outward unit normals, (m, 3) each, m, by marching cubes where seen."""
        seen = self.weights > 0
        inside = (self.distances < 0) & seen
        if not inside.any() or not ((self.distances > 0) & seen).any():
            return np.empty((0, 3)), np.empty((0, 3))
        known = seen.copy()
        for axis in range(3):
            known[(slice(None),) * axis + (slice(1, None),)] &= np.delete(known, -1, axis)
        vertices, _, normals, _ = marching_cubes(
            self.distances, 0.0, gradient_direction="ascent", mask=known
        )
        points: Floats = self.corner + (vertices + 0.5) * self.voxel
        directed = normals.any(axis=1)
        return points[directed], -normals[directed].astype(np.float64)  # skimage's point inwards


def fuse(views: Sequence[View], corner: Floats, side: float, resolution: int) -> Tsdf:
    """Fuse depth images (Curless and Levoy 1996, equal weights) into a cube: corner, side in m."""
    voxel = side / resolution
    distances = np.zeros((resolution,) * 3, dtype=np.float32)
    weights = np.zeros_like(distances)
    for view in views:
        to_camera = np.linalg.inv(view.pose)
        first = to_camera[:3, :3] @ (corner + voxel / 2) + to_camera[:3, 3]
        camera = view.intrinsics
        _integrate(
            distances,
            weights,
            np.ascontiguousarray(view.depth),
            np.asarray(first, dtype=np.float64),
            np.ascontiguousarray(voxel * to_camera[:3, :3].T),
            camera.focal,
            np.array(camera.center),
            TRUNCATION * voxel,
        )
    return Tsdf(distances, weights, corner, voxel, TRUNCATION * voxel)


@kernel()
def _integrate(
    distances: Singles,
    weights: Singles,
    depth: Singles,
    first: Floats,
    steps: Floats,
    focal: float,
    center: Floats,
    truncation: float,
) -> None:
    """Add an image to the mean; `steps` are from a voxel to the next, camera frame, (3, 3)."""
    rows, columns = depth.shape
    for i in range(len(distances)):
        for j in range(len(distances)):
            for k in range(len(distances)):
                x = first[0] + i * steps[0, 0] + j * steps[1, 0] + k * steps[2, 0]
                y = first[1] + i * steps[0, 1] + j * steps[1, 1] + k * steps[2, 1]
                z = first[2] + i * steps[0, 2] + j * steps[1, 2] + k * steps[2, 2]
                if z <= 0:
                    continue
                u = int(np.floor(x / z * focal + center[0] + 0.5))
                v = int(np.floor(y / z * focal + center[1] + 0.5))
                if not (0 <= u < columns and 0 <= v < rows) or not np.isfinite(depth[v, u]):
                    continue
                along = np.sqrt(1 + ((u - center[0]) ** 2 + (v - center[1]) ** 2) / focal**2)
                distance = (depth[v, u] - z) * along
                if distance > -truncation:
                    weight = weights[i, j, k]
                    new = min(1.0, distance / truncation)
                    distances[i, j, k] = (distances[i, j, k] * weight + new) / (weight + 1)
                    weights[i, j, k] = weight + 1

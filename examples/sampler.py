"""A grasp sampler of your own: vertical grasps around the center of mass."""

import numpy as np
import trimesh

import egad


def from_above(
    mesh: trimesh.Trimesh, gripper: egad.Gripper, n: int, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Poses (k, 4, 4) of the hand, widths (k,) in metres, and qualities (k,) of up to n grasps."""
    turns = rng.uniform(0, 2 * np.pi, n)
    x = np.stack([np.cos(turns), np.sin(turns), np.zeros(n)], axis=1)  # the closing axis
    z = np.tile([0.0, 0.0, -1.0], (n, 1))  # the approach
    lines = mesh.center_mass + 0.01 * rng.normal(size=(n, 3))  # a point of each closing line
    first, second = (_touch(mesh, lines, side * x, gripper.opening / 2) for side in (-1, 1))
    widths = np.sum((second - first) * x, axis=1)
    kept = widths > 0  # both fingers touch something; NaN if one does not
    poses = np.tile(np.eye(4), (n, 1, 1))
    poses[:, :3, :3] = np.stack([x, np.cross(z, x), z], axis=2)
    poses[:, :3, 3] = (first + second) / 2
    off = np.linalg.norm(poses[:, :3, 3] - mesh.center_mass, axis=1)
    return poses[kept], widths[kept], np.exp(-off[kept] / 0.01)


def _touch(mesh: trimesh.Trimesh, lines: np.ndarray, way: np.ndarray, far: float) -> np.ndarray:
    """Where fingers that come in from one end of the opening touch the mesh, (n, 3); or NaN."""
    points = np.full_like(lines, np.nan)
    found, rays, _ = mesh.ray.intersects_location(lines + far * way, -way, multiple_hits=False)
    points[rays] = found
    return points

"""Poses of the hand, from its frame (see `egad.grippers.hand`) to that of the object."""

import numpy as np

from egad._util.arrays import Floats


def hand_poses(centers: Floats, axes: Floats, approaches: Floats) -> Floats:
    """Poses (n, 4, 4) in our frame: x closes, z approaches, y = z cross x; centers in metres."""
    poses = np.tile(np.eye(4), (len(centers), 1, 1))
    poses[:, :3, 0] = axes
    poses[:, :3, 1] = np.cross(approaches, axes)
    poses[:, :3, 2] = approaches
    poses[:, :3, 3] = centers
    return poses

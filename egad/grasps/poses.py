"""Poses of the hand at a grasp, in the frames of different programs.

A grasp has a center, a closing axis and an approach (see `egad.grippers.hand`). All poses map
from the frame of the hand to that of the object.
"""

import numpy as np

from egad._util.arrays import Floats
from egad.grasps.antipodal import approach_directions

# From the origin of ACRONYM's hand, the flange of a Franka Panda, to its fingertips, metres.
PANDA_REACH = 0.11217


def hand_poses(centers: Floats, axes: Floats, approaches: Floats) -> Floats:
    """Poses (n, 4, 4) in our frame: x closes, z approaches, y = z cross x; centers in metres."""
    poses = np.tile(np.eye(4), (len(centers), 1, 1))
    poses[:, :3, 0] = axes
    poses[:, :3, 1] = np.cross(approaches, axes)
    poses[:, :3, 2] = approaches
    poses[:, :3, 3] = centers
    return poses


def panda_poses(poses: Floats, fingertip: float) -> Floats:
    """Poses of ACRONYM's hand, (n, 4, 4), with its fingertips at ours, `fingertip` metres ahead."""
    moved = poses.copy()
    moved[:, :3, 3] -= (PANDA_REACH - fingertip) * poses[:, :3, 2]
    return moved


def graspnet_poses(poses: Floats, depth: float) -> Floats:
    """Poses (n, 4, 4) of GraspNet's hand: x approaches, y closes; contacts at x = depth, metres."""
    moved = poses[:, :, [2, 0, 1, 3]]
    moved[:, :3, 3] -= depth * poses[:, :3, 2]
    return np.asarray(moved)


def dexnet_frames(axes: Floats) -> Floats:
    """Rotations (n, 3, 3) of Dex-Net's frame at angle 0: y closes, x approaches horizontally."""
    forward = approach_directions(axes)
    return np.stack([forward, axes, np.cross(forward, axes)], axis=2)


def dexnet_angles(axes: Floats, approaches: Floats) -> Floats:
    """Dex-Net's approach angles, radians, (n,): `cos(a) x + sin(a) z` of the frame at angle 0."""
    frames = dexnet_frames(axes)
    along = np.einsum("nk,nk->n", frames[:, :, 0], approaches)
    aside = np.einsum("nk,nk->n", frames[:, :, 2], approaches)
    return np.asarray(np.arctan2(aside, along))


def dexnet_configurations(
    centers: Floats, axes: Floats, approaches: Floats, opening: float
) -> Floats:
    """Dex-Net's (n, 10): center, axis, opening, approach angle, jaw width (0) and opening (0)."""
    rest = np.zeros((len(centers), 4))
    rest[:, 0] = opening
    rest[:, 1] = dexnet_angles(axes, approaches)
    return np.hstack([centers, axes, rest])

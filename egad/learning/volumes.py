"""Input and output of the network of VGN: a grid of distances, and grasps in its own frame.

Breyer et al., "Volumetric grasping network: real-time 6 DOF grasp detection in clutter", CoRL 2020.
"""

import numpy as np
from scipy.spatial.transform import Rotation

from egad._util.arrays import Floats, Singles
from egad.grippers import Gripper, finger_span
from egad.perception import Tsdf

# Open3D's uniform volume, which VGN was trained with, leaves out what is further from a surface.
FAR = 0.98  # of the truncation
FINGER_DEPTH = 0.05  # metres; VGN's origin lies this far before the fingertips


def encode(tsdf: Tsdf) -> Singles:
    """A field as the network sees it: from 0 inside to 1 outside, 0 far from surfaces."""
    near = (tsdf.weights > 0) & (tsdf.distances < FAR) & (tsdf.distances >= -FAR)
    grid: Singles = np.where(near, (tsdf.distances + 1) / 2, 0).astype(np.float32)
    return grid


def hand_in_network_frame(gripper: Gripper) -> Floats:
    """Our frame of the hand in that of VGN, (4, 4).

    VGN closes along y, we along x. Its origin lies 5 cm before the fingertips, ours between the
    contacts. A pose of VGN times this one is a pose of ours, and one of ours times its inverse is
    one of VGN.
    """
    frame = np.eye(4)
    frame[:3, :3] = Rotation.from_euler("z", np.pi / 2).as_matrix()
    frame[2, 3] = FINGER_DEPTH - finger_span(gripper)[1]
    return frame

import numpy as np
import pytest
from autolab_core import RigidTransform

from egad.grasps.poses import hand_poses


@pytest.fixture
def grasps():
    """Centers, axes and approaches at right angles to them; some axes are vertical."""
    rng = np.random.default_rng(4)
    axes = rng.normal(size=(50, 3))
    axes[:2] = [[0, 0, 1], [0, 0, -1]]
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    approaches = np.cross(axes, rng.normal(size=(50, 3)))
    approaches /= np.linalg.norm(approaches, axis=1, keepdims=True)
    return rng.normal(size=(50, 3)), axes, approaches


def test_a_pose_closes_along_x_and_approaches_along_z(grasps):
    centers, axes, approaches = grasps
    poses = hand_poses(*grasps)
    for pose, center, axis, approach in zip(poses, centers, axes, approaches, strict=True):
        rigid = RigidTransform(pose[:3, :3], pose[:3, 3], "hand", "object")  # checks the rotation
        assert rigid.x_axis == pytest.approx(axis)
        assert rigid.z_axis == pytest.approx(approach)
        assert rigid.translation == pytest.approx(center)

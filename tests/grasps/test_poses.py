import pytest
from autolab_core import RigidTransform
from hand_frames import hand_frames

from egad.grasps.poses import hand_poses


@pytest.fixture
def grasps():
    return hand_frames()


def test_a_pose_closes_along_x_and_approaches_along_z(grasps):
    centers, axes, approaches = grasps
    poses = hand_poses(*grasps)
    for pose, center, axis, approach in zip(poses, centers, axes, approaches, strict=True):
        rigid = RigidTransform(pose[:3, :3], pose[:3, 3], "hand", "object")  # checks the rotation
        assert rigid.x_axis == pytest.approx(axis)
        assert rigid.z_axis == pytest.approx(approach)
        assert rigid.translation == pytest.approx(center)

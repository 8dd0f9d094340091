"""Tool center points, against the numbers of the programs that have them."""

import numpy as np
import pytest
from described_hands import box_urdf, jaw_gap, jaw_urdf
from scipy.spatial.transform import Rotation

from egad.errors import UserError
from egad.grippers import Gripper, base_pose, joint_values, model_of, tcp_poses

WIDTHS = np.array([0.01, 0.03, 0.05])
# In millimetres, in the frame of the maker's link
GRIPPERFRAME, MENAGERIE = (-7.9, -0.2, -98.1), (12.0, -0.2, -98.1)


@pytest.fixture(scope="module")
def hand(tmp_path_factory):
    return Gripper.from_file(jaw_urdf(tmp_path_factory.mktemp("hand") / "jaw.urdf"))


@pytest.fixture(scope="module")
def poses():
    rng = np.random.default_rng(0)
    found = np.tile(np.eye(4), (len(WIDTHS), 1, 1))
    found[:, :3, :3] = Rotation.random(len(WIDTHS), rng).as_matrix()
    found[:, :3, 3] = rng.normal(size=(len(WIDTHS), 3))
    return found


def seen_from_link(hand, poses, convention):
    """Poses of the TCP in the frame of the link with the fixed jaw."""
    links = np.array([pose @ base_pose(hand, w) for pose, w in zip(poses, WIDTHS, strict=True)])
    return np.linalg.inv(links) @ tcp_poses(hand, poses, WIDTHS, convention)


@pytest.mark.parametrize(
    ("convention", "origin"), [("gripperframe", GRIPPERFRAME), ("menagerie", MENAGERIE)]
)
def test_sites_of_an_so101_are_where_the_files_have_them(hand, poses, convention, origin):
    for frame in seen_from_link(hand, poses, convention):
        np.testing.assert_allclose(1000 * frame[:3, 3], origin, atol=0.05)
        # quat="0.707107 0 0.707107 0" of the site, the real part first
        turn = Rotation.from_quat([0, 0.707107, 0, 0.707107]).as_matrix()
        np.testing.assert_allclose(frame[:3, :3], turn, atol=1e-6)


def test_the_fixed_jaw_has_it_where_the_maker_has(hand, poses):
    """It does not move with the opening; the depth is that of the middle of the pads."""
    depth = model_of(hand).palm_to_hand[2, 3]
    assert 1000 * depth == pytest.approx(GRIPPERFRAME[2], abs=2.5)
    for frame in seen_from_link(hand, poses, "fixed_jaw"):
        np.testing.assert_allclose(1000 * frame[:2, 3], [-7.9, 0], atol=1e-3)
        assert frame[2, 3] == pytest.approx(depth, abs=1e-9)
        np.testing.assert_allclose(
            frame[:3, :3], seen_from_link(hand, poses, "gripperframe")[0, :3, :3], atol=1e-6
        )


def test_the_midpoint_moves_by_half_of_what_the_jaw_opens(hand, poses):
    depth = model_of(hand).palm_to_hand[2, 3]
    for width, frame in zip(WIDTHS, seen_from_link(hand, poses, "midpoint"), strict=True):
        (joint,) = joint_values(hand, width).values()
        expected = [-0.0079 + jaw_gap(joint, depth) / 2, 0, depth]
        np.testing.assert_allclose(frame[:3, 3], expected, atol=1e-5)
        np.testing.assert_allclose(frame[:3, :3], np.eye(3), atol=1e-9)


def test_no_grasps_have_no_poses(hand):
    assert tcp_poses(hand, np.empty((0, 4, 4)), [], "fixed_jaw").shape == (0, 4, 4)


def test_what_has_no_such_point_is_told(hand, poses, tmp_path):
    with pytest.raises(UserError, match="convention 'tip' is not known"):
        tcp_poses(hand, poses, WIDTHS, "tip")
    for wrong in ((poses[0], WIDTHS), (poses, WIDTHS[:1])):
        with pytest.raises(UserError, match=r"poses must have the shape \(n, 4, 4\)"):
            tcp_poses(hand, *wrong, "midpoint")
    parallel = Gripper.from_file(box_urdf(tmp_path / "hand.urdf"))
    with pytest.raises(UserError, match="both fingers of this gripper move"):
        tcp_poses(parallel, poses, WIDTHS, "midpoint")

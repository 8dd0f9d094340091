"""Whether the hand collides with what is seen."""

import itertools

import numpy as np
import pytest

from egad.detectors import in_collision
from egad.errors import UserError
from egad.grasps import TABLE_CLEARANCE
from egad.grippers import GRIPPERS, BoxBody

HAND = GRIPPERS["panda"]


def test_it_collides_with_points_in_a_box_of_the_moving_hand():
    """Against the parts of the hand, tested point by point, for poses in any direction."""
    rng = np.random.default_rng(1)
    poses = np.tile(np.eye(4), (40, 1, 1))
    poses[:, :3, :3] = [np.linalg.qr(rng.normal(size=(3, 3)))[0] for _ in poses]
    poses[:, :3, :3] *= np.linalg.det(poses[:, :3, :3])[:, None, None]
    poses[:, :3, 3] = (0, 0, 1.0)  # far above the table
    points = poses[0, :3, 3] + rng.uniform(-0.15, 0.15, (6, 3))
    widths = rng.uniform(0.02, HAND.opening, len(poses))
    expected = []
    for pose, width in zip(poses, widths, strict=True):
        parts = BoxBody(HAND.model_copy(update={"opening": float(width)})).parts(0.05)
        local = (points - pose[:3, 3]) @ pose[:3, :3]
        expected.append(
            any(
                ((part.box[0] <= point) & (point <= part.box[1])).all()
                for part in parts
                for point in local
            )
        )
    found = in_collision(poses, widths, points, HAND)
    assert found.tolist() == expected
    assert 5 < found.sum() < 35


def test_the_hand_does_not_begin_its_way_inside_the_table():
    """Nearly level and slightly upwards: the palm is lowest where the way begins."""
    z = np.array([0.0, np.cos(0.19), np.sin(0.19)])
    x = np.array([1.0, 0.0, 0.0])
    pose = np.eye(4)
    pose[:3, :3] = np.column_stack([x, np.cross(z, x), z])
    for height in np.linspace(0.02, 0.09, 15):
        pose[2, 3] = height
        corners = [
            point @ pose[:3, :3].T + pose[:3, 3]
            for part in BoxBody(HAND).parts(0.05)
            for point in itertools.product(*part.box.T)
        ]
        lowest = min(corner[2] for corner in corners)
        nothing = np.empty((0, 3))
        collides = in_collision(pose[None], np.array([HAND.opening]), nothing, HAND)[0]
        assert collides == (lowest < TABLE_CLEARANCE)


def test_a_hand_with_a_suction_cup_is_refused():
    with pytest.raises(UserError, match="a check for collisions"):
        in_collision(np.eye(4)[None], np.zeros(1), np.zeros((1, 3)), GRIPPERS["cup_30mm"])

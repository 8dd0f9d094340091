"""antipodal-cloud proposes what a hand can do with what is seen."""

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from egad.detectors.cloud import MIN_CLEARANCE, TORQUE_SCALING, antipodal_cloud
from egad.detectors.observation import PointCloud
from egad.grippers import GRIPPERS, BoxBody

HAND = GRIPPERS["panda"]


def cloud_of(mesh, count=4000):
    """Points all over a mesh, as if cameras saw it from everywhere."""
    points, faces = trimesh.sample.sample_surface(mesh, count, seed=1)
    return PointCloud(np.asarray(points), mesh.face_normals[faces])


def standing(sides, turn=0.0):
    box = trimesh.creation.box(sides)
    box.apply_transform(trimesh.transformations.rotation_matrix(turn, [0, 0, 1]))
    return box.apply_translation([0.02, -0.03, sides[2] / 2])


def found(mesh, seed=0):
    return antipodal_cloud(cloud_of(mesh), HAND, np.random.default_rng(seed))


@pytest.mark.parametrize("turn", [0.0, 0.5, 1.2])
def test_a_bar_is_grasped_across(turn):
    grasps = found(standing((0.03, 0.12, 0.05), turn))
    across = Rotation.from_euler("z", turn).apply([1, 0, 0])
    assert len(grasps.poses) > 10
    friction_cone = np.cos(np.arctan(HAND.pad.friction))
    assert (np.abs(grasps.poses[:, :3, 0] @ across) >= friction_cone - 1e-9).all()
    assert (np.diff(grasps.scores) <= 0).all()
    assert ((grasps.scores > 0) & (grasps.scores <= 1)).all()


def test_the_best_grasp_of_a_block_is_through_its_middle():
    mesh = standing((0.03, 0.12, 0.05))
    best = found(mesh).poses[0]
    off = best[:3, 3] - mesh.center_mass
    off -= (off @ best[:3, 0]) * best[:3, 0]
    assert np.linalg.norm(off) < 1 / TORQUE_SCALING


def test_the_hand_touches_neither_object_nor_table_on_its_way():
    mesh = standing((0.03, 0.12, 0.05))
    points = cloud_of(mesh, 20000).points
    table = np.random.default_rng(0).uniform([-0.3, -0.3, 0], [0.3, 0.3, 0], (20000, 3))
    scene = np.concatenate([points, table])
    grasps = found(mesh)
    for pose, width in zip(grasps.poses[:10], grasps.widths, strict=False):
        hand = HAND.model_copy(update={"opening": float(width)})
        local = (scene - pose[:3, 3]) @ pose[:3, :3]
        for part in BoxBody(hand).parts(0.05):
            inside = ((local > part.box[0] + 0.001) & (local < part.box[1] - 0.001)).all(axis=1)
            assert not inside.any()


def test_what_is_too_wide_is_not_grasped():
    side = HAND.opening - 2 * MIN_CLEARANCE + 0.001
    assert len(found(standing((side, side, 0.1))).poses) == 0


def test_without_points_there_is_no_grasp():
    empty = PointCloud(np.empty((0, 3)), np.empty((0, 3)))
    assert len(antipodal_cloud(empty, HAND, np.random.default_rng(0)).poses) == 0


def test_the_same_seed_gives_the_same_grasps():
    mesh = standing((0.03, 0.12, 0.05))
    first, again, other = found(mesh, 1), found(mesh, 1), found(mesh, 2)
    np.testing.assert_array_equal(first.poses, again.poses)
    assert first.poses.shape != other.poses.shape or (first.poses != other.poses).any()

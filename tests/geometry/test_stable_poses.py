"""Stable poses: known solids, and what being at rest means."""

import numpy as np
import pytest
import trimesh

from egad.errors import RejectedError
from egad.geometry.mass import mass_properties
from egad.geometry.stable_poses import group_poses, resting_poses, rotation_to_table


def poses_of(mesh):
    return resting_poses(mesh, mass_properties(mesh, 1.0).com)


def blob(seed):
    rng = np.random.default_rng(seed)
    return trimesh.Trimesh(rng.normal(size=(14, 3)) * [0.02, 0.03, 0.05]).convex_hull


def face_share(a, b, h):
    """Part of all directions that meet a face of 2 a x 2 b at distance h."""
    return np.arctan(a * b / (h * np.sqrt(a * a + b * b + h * h))) / np.pi


def test_a_cube_rests_on_each_of_its_six_faces_alike():
    poses = poses_of(trimesh.creation.box((0.04, 0.04, 0.04)).apply_translation([1, 2, 3]))
    assert len(poses) == 6
    assert sorted(tuple(pose.normal.round(9) + 0.0) for pose in poses) == sorted(
        tuple(sign * axis) for axis in np.eye(3) for sign in (-1.0, 1.0)
    )
    for pose in poses:
        assert pose.probability == pytest.approx(1 / 6)
        assert pose.height == pytest.approx(0.02)
        assert pose.margin == pytest.approx(np.pi / 4)
        assert len(pose.face) == 4


def test_a_block_rests_on_a_face_as_often_as_its_solid_angle_says():
    half = np.array([0.01, 0.02, 0.04])
    poses = poses_of(trimesh.creation.box(2 * half))
    assert [np.abs(pose.normal).argmax() for pose in poses] == [0, 0, 1, 1, 2, 2]
    for pose in poses:
        axis = np.abs(pose.normal).argmax()
        a, b = np.delete(half, axis)
        assert pose.probability == pytest.approx(face_share(a, b, half[axis]), rel=1e-9)
        assert pose.margin == pytest.approx(np.arctan(min(a, b) / half[axis]))


def test_a_leaning_prism_falls_off_its_small_faces():
    base = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    prism = trimesh.Trimesh(np.concatenate([base, base + np.array([2.5, 0, 1])])).convex_hull
    poses = poses_of(prism)
    assert not any(abs(pose.normal[2]) > 0.999 for pose in poses)
    assert sum(pose.probability for pose in poses) == pytest.approx(1)


def test_a_heavy_end_lies_below():
    bar = trimesh.creation.box((0.02, 0.02, 0.1))
    poses = resting_poses(bar, np.array([0.0, 0.0, -0.049]))
    down = next(pose for pose in poses if pose.normal[2] < -0.99)
    assert down.height == pytest.approx(0.001)
    assert bar.vertices[down.face][:, 2] == pytest.approx([-0.05] * 4)
    assert down.probability > 0.3


def test_nearly_the_same_poses_of_a_round_object_are_joined_with_all_their_chances():
    poses = poses_of(trimesh.creation.icosphere(subdivisions=3))
    joined = group_poses(poses, np.radians(30))
    assert len(joined) < len(poses)
    assert sum(pose.probability for pose in joined) == pytest.approx(1)
    normals = np.array([pose.normal for pose in joined])
    apart = np.degrees(np.arccos(np.clip(normals @ normals.T, -1, 1)))
    assert apart[~np.eye(len(joined), dtype=bool)].min() >= 30 - 1e-9


@pytest.mark.parametrize("seed", range(6))
def test_poses_stand_on_the_table_and_their_chances_add_up(seed):
    mesh = blob(seed)
    center = mass_properties(mesh, 1.0).com
    poses = resting_poses(mesh, center)
    assert sum(pose.probability for pose in poses) == pytest.approx(1)
    for pose in poses:
        placed = trimesh.transform_points(mesh.vertices, pose.matrix)
        assert np.abs(placed[pose.face, 2]).max() < 1e-12
        assert placed[:, 2].min() > -1e-12
        moved = trimesh.transform_points([center], pose.matrix)[0]
        np.testing.assert_allclose(moved, [0, 0, pose.height], atol=1e-12)
        assert 0 <= pose.margin < np.pi / 2
        assert np.linalg.det(pose.rotation) == pytest.approx(1)


@pytest.mark.parametrize("seed", range(6))
def test_at_rest_the_center_of_mass_is_lower_than_in_any_pose_nearby(seed):
    mesh = blob(seed)
    center = mass_properties(mesh, 1.0).com
    nearby = np.random.default_rng(seed).normal(scale=1e-3, size=(500, 3))
    for pose in resting_poses(mesh, center):
        if pose.margin < 0.01:
            continue
        tilted = pose.normal + nearby
        tilted /= np.linalg.norm(tilted, axis=1, keepdims=True)
        heights = ((mesh.vertices - center) @ tilted.T).max(axis=0)
        assert heights.min() > pose.height


@pytest.mark.parametrize("normal", [[0, 0, 1], [0, 0, -1], [1, 0, 0], [0.6, 0, 0.8], [0, 1e-9, 1]])
def test_the_resting_face_is_turned_down(normal):
    unit = np.array(normal, float) / np.linalg.norm(normal)
    turn = rotation_to_table(unit)
    np.testing.assert_allclose(turn @ unit, [0, 0, -1], atol=1e-12)
    np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(turn) == pytest.approx(1)


def test_units_and_order_do_not_matter():
    mesh = blob(3)
    poses = poses_of(mesh)
    big = trimesh.Trimesh(1000 * mesh.vertices[::-1], len(mesh.vertices) - 1 - mesh.faces)
    assert [p.probability for p in poses_of(big)] == pytest.approx([p.probability for p in poses])


@pytest.mark.parametrize("center", [(0, 0, 0.06), (0, 0, 0.05), (1, 1, 1), (np.nan, 0, 0)])
def test_a_center_of_mass_that_is_not_inside_is_rejected(center):
    bar = trimesh.creation.box((0.02, 0.02, 0.1))
    with pytest.raises(RejectedError, match="center of mass is not inside"):
        resting_poses(bar, np.array(center, dtype=float))


@pytest.mark.parametrize("squeeze", [(1, 1, 0), (1, 0, 0), (0, 0, 0), (1, 1, np.nan)])
def test_what_has_no_hull_is_rejected(squeeze):
    box = trimesh.creation.box((0.02, 0.03, 0.04))
    flat = trimesh.Trimesh(box.vertices * squeeze, box.faces, process=False)
    with pytest.raises(RejectedError, match=r"flat|not finite"):
        resting_poses(flat, np.zeros(3))


@pytest.mark.parametrize("thickness", [1e-6, 1e-9, 1e-12, 1e-15])
def test_a_sheet_of_no_thickness_to_speak_of_lies_on_its_sides_or_is_rejected(thickness):
    sheet = trimesh.creation.box((0.1, 0.1, thickness))
    try:
        poses = resting_poses(sheet, np.zeros(3))
    except RejectedError:
        assert thickness < 1e-9
    else:
        assert sum(pose.probability for pose in poses) == pytest.approx(1)
        assert {abs(round(pose.normal[2])) for pose in poses[:2]} == {1}

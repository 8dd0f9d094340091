"""Observations show the scene: all objects, from all around."""

import numpy as np
import pytest
import trimesh

from egad.detectors import (
    DepthCamera,
    Intrinsics,
    Observation,
    add_noise,
    camera_above,
    cameras_around,
    render_scene,
)

CAMERA = Intrinsics(160, 120, 104.0, (79.5, 59.5))
FINE = Intrinsics(320, 240, 208.0, (159.5, 119.5))
BOX = trimesh.creation.box((0.04, 0.06, 0.05))
BALL = trimesh.creation.icosphere(4, 0.03)


def at(x, y, z):
    return trimesh.transformations.translation_matrix((x, y, z))


def test_cameras_look_at_the_target_from_all_around():
    target, tilt = np.array([0.1, 0.2, 0.3]), 0.6
    poses = cameras_around(target, 5, 0.7, tilt)
    for pose in poses:
        np.testing.assert_allclose(pose[:3, :3].T @ pose[:3, :3], np.eye(3), atol=1e-12)
        assert np.linalg.det(pose[:3, :3]) > 0
        np.testing.assert_allclose(pose[:3, 3] + 0.7 * pose[:3, 2], target, atol=1e-12)
        np.testing.assert_allclose(-pose[2, 2], np.cos(tilt))
        assert abs(pose[2, 0]) < 1e-12  # rows of the image are level
        assert pose[2, 1] < 0  # and its lower side is down
    angles = np.sort([np.arctan2(*(pose[:2, 3] - target[:2])) for pose in poses])
    np.testing.assert_allclose(np.diff(angles), 2 * np.pi / 5)


def test_a_scene_looks_like_one_mesh_of_all_objects():
    places = [at(-0.03, 0, 0.025), at(0.04, 0.01, 0.03)]
    moved = [mesh.copy() for mesh in (BOX, BALL)]
    for mesh, place in zip(moved, places, strict=True):
        mesh.apply_transform(place)
    together = trimesh.util.concatenate(moved)
    cameras = [DepthCamera(BOX), DepthCamera(BALL)]
    for pose in cameras_around(np.zeros(3), 3, 0.5, 1.0):
        found = render_scene(cameras, places, CAMERA, pose)
        expected = DepthCamera(together).render(np.eye(4), CAMERA, pose)
        np.testing.assert_allclose(found.depth, expected.depth, atol=1e-5)


def test_a_mask_says_which_object_each_pixel_sees():
    """A point that a pixel sees lies on its object, or else on the table; noise changes nothing."""
    places = [at(-0.03, 0, 0.025), at(0.04, 0.01, 0.03)]
    cameras = [DepthCamera(BOX), DepthCamera(BALL)]
    for pose in cameras_around(np.zeros(3), 3, 0.5, 1.0):
        view = render_scene(cameras, places, CAMERA, pose)
        points = view.points() - places[0][:3, 3]
        on_box = (np.abs(points) <= BOX.extents / 2 + 1e-5).all(axis=2)
        from_ball = np.linalg.norm(view.points() - places[1][:3, 3], axis=2)
        np.testing.assert_array_equal(view.mask == 1, on_box & (view.points()[..., 2] > 1e-5))
        np.testing.assert_array_equal(view.mask == 2, np.abs(from_ball - 0.03) < 1e-3)
        noisy = add_noise("stereo", view, np.random.default_rng(0))
        np.testing.assert_array_equal(noisy.mask, view.mask)


def test_the_cloud_lies_on_the_objects_and_not_on_the_table():
    place = at(0.02, -0.03, 0.025)
    cameras = [DepthCamera(BOX)]
    views = [
        render_scene(cameras, [place], CAMERA, pose)
        for pose in cameras_around(np.zeros(3), 6, 0.5, np.radians(30))
    ]
    above = render_scene(cameras, [place], CAMERA, camera_above(0.6))
    cloud = Observation(above, tuple(views), 0.3).cloud
    beyond = np.abs(cloud.points - place[:3, 3]) - BOX.extents / 2
    outside = np.linalg.norm(np.maximum(beyond, 0), axis=1)
    away = np.abs(outside + np.minimum(beyond.max(axis=1), 0))
    assert len(cloud.points) > 1000
    assert away.max() < 0.006
    assert np.median(away) < 0.0025
    top = cloud.points[:, 2] > 0.049
    assert (cloud.normals[top, 2] > 0.9).mean() > 0.8


def observation_of(meshes, places, sigma=0.0):
    cameras = [DepthCamera(mesh) for mesh in meshes]
    views = [
        render_scene(cameras, places, FINE, pose)
        for pose in [*cameras_around(np.zeros(3), 6, 0.5, np.radians(30)), camera_above(0.6)]
    ]
    return Observation(views[-1], tuple(views[:-1]), 0.3, sigma)


def surfaces_of_box_and_ball(points, box_at, ball_at):
    """Distances from both surfaces, (2, n)."""
    beyond = np.abs(points - box_at) - BOX.extents / 2
    box = np.linalg.norm(np.maximum(beyond, 0), axis=1) + np.minimum(beyond.max(axis=1), 0)
    return np.abs([box, np.linalg.norm(points - ball_at, axis=1) - 0.03])


BESIDE = [at(-0.02, 0, 0.025), at(0.0301, 0.01, 0.03)]  # 0.1 mm apart


@pytest.mark.parametrize("sigma", [0.0, 0.0008])
def test_every_point_belongs_to_the_object_on_whose_surface_it_lies(sigma):
    found = observation_of([BOX, BALL], BESIDE, sigma)
    box, ball = surfaces_of_box_and_ball(found.cloud.points, *(each[:3, 3] for each in BESIDE))
    assert set(found.point_objects.tolist()) == {1, 2}
    own = np.where(found.point_objects == 1, box, ball)
    assert np.median(own) < 0.002
    excess = own - np.minimum(box, ball)
    assert (excess > 0.001).mean() < 0.01
    assert excess.max() < 0.005 + 4 * sigma  # two voxels
    for number, cloud in enumerate(found.object_clouds, start=1):
        chosen = found.point_objects == number
        np.testing.assert_array_equal(cloud.points, found.cloud.points[chosen])
        np.testing.assert_array_equal(cloud.normals, found.cloud.normals[chosen])


def test_views_without_masks_tell_no_objects_apart():
    view = DepthCamera(BOX).render(at(0, 0, 0.025), CAMERA, camera_above(0.6))
    with pytest.raises(ValueError, match="masks"):
        _ = Observation(view, (view,), 0.3).object_clouds

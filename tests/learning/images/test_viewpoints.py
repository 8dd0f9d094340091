"""Objects lie as they come to rest, and cameras are where their settings say."""

import numpy as np
import pytest
import trimesh

from egad.geometry.stable_poses import resting_poses
from egad.learning.images import CAMERAS
from egad.learning.images.viewpoints import sample_object_poses, sample_scene

CENTER = np.array([0.001, -0.002, 0.003])


@pytest.fixture(scope="module")
def poses():
    return resting_poses(trimesh.creation.box((0.03, 0.06, 0.04)), CENTER)


def scenes(poses, camera, count=300):
    """Scenes whose matrix is that of an object in its first pose."""
    center = (poses[0].matrix @ [*CENTER, 1])[:3]
    found = [sample_scene(center, camera, np.random.default_rng(seed)) for seed in range(count)]
    return [scene._replace(matrix=scene.matrix @ poses[0].matrix) for scene in found]


def test_poses_come_up_by_their_probabilities(poses):
    drawn = sample_object_poses(poses, 1000, np.random.default_rng(0))
    found = np.bincount(drawn, minlength=len(poses))
    expected = 1000 * np.array([pose.probability for pose in poses])
    assert (np.abs(found - expected) < 1).all()
    assert (np.diff(drawn) >= 0).all()


@pytest.mark.parametrize("name", CAMERAS)
def test_ranges_are_kept_and_filled(poses, name):
    camera = CAMERAS[name]
    seen = scenes(poses, camera)
    positions = np.array([scene.camera[:3, 3] for scene in seen])
    distance = np.linalg.norm(positions, axis=1)
    tilt = np.degrees(np.arccos(positions[:, 2] / distance))
    shift = np.array([(scene.matrix @ [*CENTER, 1])[:2] for scene in seen])
    focal = [scene.intrinsics.focal for scene in seen]
    for values, (low, high) in (
        (distance, camera.distance),
        (tilt, camera.tilt),
        (shift, (-camera.shift, camera.shift)),
        (focal, camera.focal),
    ):
        assert np.min(values) >= low - 1e-9
        assert np.max(values) <= high + 1e-9
        assert np.ptp(values) >= 0.95 * (high - low)


@pytest.mark.parametrize("name", CAMERAS)
def test_objects_rest_and_cameras_look_at_the_table(poses, name):
    corners = trimesh.creation.box((0.03, 0.06, 0.04)).vertices
    for scene in scenes(poses, CAMERAS[name], 20):
        heights = corners @ scene.matrix[2, :3] + scene.matrix[2, 3]
        assert heights.min() == pytest.approx(0, abs=1e-12)
        turn = scene.camera[:3, :3]
        np.testing.assert_allclose(turn.T @ turn, np.eye(3), atol=1e-12)
        assert np.linalg.det(turn) > 0
        forward = scene.camera[:3, 2]
        reach = scene.camera[2, 3] / -forward[2]
        np.testing.assert_allclose((scene.camera[:3, 3] + reach * forward)[:2], 0, atol=1e-12)


def test_a_centered_image_is_cut_out_around_the_object(poses):
    for scene in scenes(poses, CAMERAS["dexnet"], 20):
        seen = np.linalg.inv(scene.camera) @ scene.matrix @ [*CENTER, 1]
        np.testing.assert_allclose(scene.intrinsics.pixels(seen[None, :3]), [[149.5, 149.5]])

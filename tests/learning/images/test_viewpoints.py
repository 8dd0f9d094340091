"""Objects lie as they come to rest, and cameras are where their settings say."""

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from egad.detectors import Intrinsics, camera_above
from egad.detectors.camera import LOOKING_DOWN
from egad.geometry.stable_poses import resting_poses
from egad.learning.images import CAMERAS
from egad.learning.images.viewpoints import sample_object_poses, sample_scene
from egad_workflow.settings import Settings

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


def test_a_single_image_has_any_pose(poses):
    drawn = [sample_object_poses(poses, 1, np.random.default_rng(seed))[0] for seed in range(4000)]
    found = np.bincount(drawn, minlength=len(poses)) / 4000
    expected = np.array([pose.probability for pose in poses])
    assert np.abs(found - expected).max() < 4 * np.sqrt(0.25 / 4000)
    assert len(sample_object_poses(poses, 0, np.random.default_rng(0))) == 0


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


def test_turns_of_object_and_camera_are_spread_over_their_ranges(poses):
    """Each quarter of what is possible comes up as often: yaw, where the camera leans, its roll."""
    camera = CAMERAS["dexnet"].model_copy(update={"roll": (-30.0, 60.0)})
    yaws, leans, rolls = [], [], []
    for scene in scenes(poses, camera, 1000):
        turn = scene.matrix[:3, :3] @ poses[0].matrix[:3, :3].T
        yaws.append(np.arctan2(turn[1, 0], turn[0, 0]))
        up = -scene.camera[:3, 2]
        leans.append(np.arctan2(up[1], up[0]))
        axis = np.array([-up[1], up[0], 0])  # upright, it is turned about this to look from there
        upright = Rotation.from_rotvec(axis / np.linalg.norm(axis) * np.arccos(up[2])).inv()
        rolled = LOOKING_DOWN.T @ upright.as_matrix() @ scene.camera[:3, :3]
        rolls.append(np.degrees(np.arctan2(rolled[1, 0], rolled[0, 0])))
    for values, ends in ((yaws, (-np.pi, np.pi)), (leans, (-np.pi, np.pi)), (rolls, camera.roll)):
        counts, _ = np.histogram(values, np.linspace(*ends, 5))
        assert counts.sum() == 1000
        assert np.abs(counts - 250).max() < 5 * np.sqrt(1000 * 0.25 * 0.75)


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


def test_a_camera_that_does_not_tilt_is_that_of_the_trials(poses):
    trials = Settings().trials
    upright = CAMERAS["d435"].model_copy(update={"tilt": (0.0, 0.0), "distance": (0.6, 0.6)})
    scene = scenes(poses, upright, 1)[0]
    np.testing.assert_allclose(scene.camera, camera_above(trials.camera_height), atol=1e-12)
    whole = Intrinsics.spanning(*trials.image, trials.field_of_view)
    assert scene.intrinsics.focal == pytest.approx(whole.focal, abs=0.1)


def test_a_centered_image_is_cut_out_around_the_object(poses):
    for scene in scenes(poses, CAMERAS["dexnet"], 20):
        seen = np.linalg.inv(scene.camera) @ scene.matrix @ [*CENTER, 1]
        np.testing.assert_allclose(scene.intrinsics.pixels(seen[None, :3]), [[149.5, 149.5]])

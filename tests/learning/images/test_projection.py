"""Rectangles lie in the image where rays meet the contacts."""

import numpy as np
import pytest
import trimesh

from egad.detectors import DepthCamera, Intrinsics, camera_above
from egad.grasps.collision import roomy
from egad.learning.images import CAMERAS, half_turn
from egad.learning.images.rectangles import project_grasps
from egad.learning.images.viewpoints import CameraScene, sample_scene

CAMERA = Intrinsics(300, 300, 417.0, (149.5, 149.5))


@pytest.fixture
def one(known_grasps):
    """A single grasp."""
    return lambda axis, width=0.03, center=(0, 0, 0): known_grasps([center], [axis], [width])


@pytest.mark.parametrize("degrees", [-90, -60, -1, 0, 30, 89])
def test_angles_are_anticlockwise_from_the_right(degrees, hand, one):
    """Seen from above x is right and y is up in the image."""
    angle = np.radians(degrees)
    axis = (np.cos(angle), np.sin(angle), 0)
    scene = CameraScene(np.eye(4), CAMERA, camera_above(0.6))
    found = project_grasps(scene, one(axis), hand.gripper)
    assert found.angle[0] == pytest.approx(angle, abs=1e-9)


def test_center_opening_and_depth(hand, one):
    place = trimesh.transformations.translation_matrix((0.06, 0.03, 0.1))
    scene = CameraScene(place, CAMERA, camera_above(0.6))
    found = project_grasps(scene, one((1.0, 0, 0)), hand.gripper)
    assert found.quality.tolist() == [0.2]
    assert found.depth_center[0] == pytest.approx(0.5)
    assert found.u[0] == pytest.approx(149.5 + 0.06 / 0.5 * 417)
    assert found.v[0] == pytest.approx(149.5 - 0.03 / 0.5 * 417)
    assert found.opening[0] == pytest.approx(roomy(np.array([0.03]), hand.gripper)[0] / 0.5 * 417)


def test_what_is_beside_the_image_is_left_out(hand, one):
    for x, count in ((0.21, 1), (0.22, 0)):
        place = trimesh.transformations.translation_matrix((x, 0, 0))
        scene = CameraScene(place, CAMERA, camera_above(0.6))
        found = project_grasps(scene, one((0, 1.0, 0)), hand.gripper)
        assert len(found.u) == len(found.collision_free) == count


@pytest.mark.parametrize("name", CAMERAS)
def test_the_rectangle_meets_the_object_at_the_contacts(block, hand, one, name):
    """Along the line of the opening the mask begins and ends where the contacts are.

    The contacts are on the upper edges of the block, so that the camera sees them.
    """
    eye, top = DepthCamera(block), 0.0399
    grasp = one((1.0, 0, 0), 0.03, (0, 0.01, top))
    resting = trimesh.transformations.translation_matrix((0, 0, 0.02))
    for seed in range(10):
        scene = sample_scene(resting[:3, 3], CAMERAS[name], np.random.default_rng(seed))
        depth = eye.render(scene.matrix @ resting, scene.intrinsics, scene.camera).depth
        found = project_grasps(scene, grasp, hand.gripper)
        along = np.array([np.cos(found.angle[0]), -np.sin(found.angle[0])])
        half = 0.015 * scene.intrinsics.focal / found.depth_center[0]
        for sign in (-1, 1):
            inner, outer = (
                np.round([found.u[0], found.v[0]] + sign * (half + pixels) * along).astype(int)
                for pixels in (-1.5, 3.0)
            )
            assert depth[inner[1], inner[0]] < found.depth_center[0] + 0.001
            assert depth[outer[1], outer[0]] > found.depth_center[0] + 0.005
        ends = found.ends()[0]
        reach = np.linalg.norm(ends[1] - ends[0]) - 2 * half
        assert reach == pytest.approx(2 * 0.008 / 0.015 * half, rel=1e-6)


def test_lines_have_angles_of_half_a_turn():
    angles = half_turn(np.array([-np.pi, -np.pi / 2, 0.0, np.pi / 2, np.pi, 3.0]))
    np.testing.assert_allclose(angles, [0, -np.pi / 2, 0, -np.pi / 2, 0, 3 - np.pi], atol=1e-12)
    tiny = half_turn(np.array([-np.pi / 2 - 1e-17, np.nextafter(-np.pi / 2, -2)]))
    assert (tiny >= -np.pi / 2).all()
    assert (tiny < np.pi / 2).all()

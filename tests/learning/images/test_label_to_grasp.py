"""From a label to the image, to maps, and by the detector back to a grasp of the world."""

import numpy as np
import pytest

from egad.detectors.ggcnn import MapDetector
from egad.grippers import GRIPPERS
from egad.learning.images import Share, half_turn, views_of
from egad.learning.images.rendering import Labelled
from egad.learning.targets import targets

HAND = GRIPPERS["egad_75mm"]
PIXEL = 0.0015  # metres, at the distance of the camera
SHARE = Share("id-1", "A1", "train", 0, 12, "single", ("A1",))


def answers(lying, known_grasps, rendering):
    """A label in many images, each with what a detector makes of it that has learnt it half."""
    across = known_grasps([(0, 0.01, 0.025)], [(1.0, 0, 0)], [0.03])
    labelled = Labelled((lying,), across, 1)
    for picture in views_of(labelled, SHARE, rendering(), ("id-1",)):
        seen = picture.grasps
        breadth = 0.02 * picture.view.intrinsics.focal / seen.depth_center
        painted = targets(np.column_stack([seen.u, seen.v, seen.angle, seen.opening, breadth]))
        detect = MapDetector(lambda _, answer=0.5 * painted: answer)
        yield picture, detect(picture.view, HAND, np.random.default_rng(0))[0]


def test_a_label_comes_back_as_the_grasp_that_it_was(lying, known_grasps, rendering):
    found = list(answers(lying, known_grasps, rendering))
    assert len(found) == 12
    for picture, grasp in found:
        matrix = picture.objects[0].matrix
        center, axis = matrix @ [0, 0.01, 0.005, 1], matrix[:3, 0]
        camera, view = picture.view.intrinsics, np.linalg.inv(picture.view.pose)
        seen = (view @ [*grasp.center, 1])[None, :3]
        expected = (picture.grasps.u[0], picture.grasps.v[0])
        np.testing.assert_allclose(camera.pixels(seen)[0], expected, atol=1.0)
        # The camera looks down at an angle: an error of height moves the place by a fraction.
        height = abs(center[2] - grasp.center[2])
        assert np.hypot(*(center[:2] - grasp.center[:2])) < PIXEL + 0.35 * height
        turn = half_turn(grasp.angle - np.arctan2(axis[1], axis[0]))
        assert turn == pytest.approx(0, abs=np.radians(3))
        assert grasp.width == pytest.approx(0.03 + 2 * 0.008, abs=2 * PIXEL)

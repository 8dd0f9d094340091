"""What cameras see of a box on a table."""

import numpy as np
import pytest
import trimesh

from egad.detectors import (
    DepthCamera,
    Intrinsics,
    Observation,
    camera_above,
    cameras_around,
    render_scene,
)


@pytest.fixture(scope="session")
def observation():
    """A box of 3 x 4 x 5 cm in the middle, seen by small cameras."""
    eyes, pose = [DepthCamera(trimesh.creation.box((0.03, 0.04, 0.05)))], np.eye(4)
    pose[2, 3] = 0.025

    def seen(camera):
        return render_scene(eyes, [pose], Intrinsics.spanning(80, 60, 50.0), camera)

    around = cameras_around(np.zeros(3), 6, 0.6, np.radians(30))
    return Observation(seen(camera_above(0.6)), tuple(seen(each) for each in around), 0.3)

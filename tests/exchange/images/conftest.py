"""Pictures of a block with known grasps, and where these are in them."""

import numpy as np
import pytest
import trimesh

from egad.grasps.collision import SIDE_CLEARANCE
from egad.grippers import BoxBody
from egad.perception.parameters import RenderParameters
from egad.perception.reachability import GraspCandidates
from egad.perception.rendering import pictures
from egad.perception.splits import Share
from egad.pipeline.config import CAMERAS, GRIPPERS, Settings
from egad.pipeline.config.stage_settings import select

SIDES = np.array([0.03, 0.06, 0.04])
AXES = np.vstack([np.eye(3), [[1.0, 0, 0]]])
WIDTHS = np.append(SIDES, 0.01)


@pytest.fixture(scope="session")
def sets():
    """Pictures of a block by camera; a grasp across each pair of its sides, and a narrow one.

    The latter collides: the fingers would stand in the block.
    """
    block = trimesh.creation.box(SIDES)
    grasps = GraspCandidates(np.arange(4), np.zeros((4, 3)), AXES, WIDTHS, np.full(4, 0.003))
    hand = BoxBody(GRIPPERS["egad_75mm"])

    def made(camera, **noise):
        changed = {"render": {"camera": camera}, "image_noise": noise}
        settings = select(Settings.model_validate(changed), RenderParameters, "egad_75mm")
        shares = [
            Share("id-1", "A1", "train", 0, 4),
            Share("id-2", "B2", "validation", 4, 2),
            Share("id-3", "C3", "test", 6, 2),
        ]
        return [p for share in shares for p in pictures(block, grasps, share, hand, settings)]

    return {name: made(name) for name in CAMERAS} | {"noisy": made("d435", missing=0.02)}


@pytest.fixture(scope="session")
def contacts():
    """From a picture to where the contacts of each of its grasps are in it, pixels, (n, 2, 2)."""

    def found(picture):
        to_camera = np.linalg.inv(picture.view.pose) @ picture.matrix
        numbers = picture.grasps.grasp
        ends = np.array([-0.5, 0.5])[:, None] * (WIDTHS[:, None] * AXES)[numbers, None]
        seen = ends.reshape(-1, 3) @ to_camera[:3, :3].T + to_camera[:3, 3]
        return picture.view.intrinsics.pixels(seen).reshape(-1, 2, 2)

    return found


@pytest.fixture(scope="session")
def check_rectangle():
    """Checks a rectangle (row, column; anticlockwise) against the contacts in its image."""

    def check(center, angle, opening, expected, picture, depth_center, scale=1.0):
        along = np.array([np.cos(angle), -np.sin(angle)])
        middle = expected.mean(axis=0)
        np.testing.assert_allclose([center[1], center[0]], middle, atol=0.02 * scale + 0.6)
        apart = expected[1] - expected[0]
        assert abs(along @ apart) == pytest.approx(np.linalg.norm(apart), rel=1e-3)
        room = 2 * SIDE_CLEARANCE * picture.view.intrinsics.focal / depth_center * scale
        assert opening == pytest.approx(np.linalg.norm(apart) + room, rel=0.05)

    return check

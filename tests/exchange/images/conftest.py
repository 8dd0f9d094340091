"""Pictures of a block with known grasps, and where these are in them."""

import numpy as np
import pytest
import trimesh

from egad.grasps.collision import SIDE_CLEARANCE
from egad.learning.images import CAMERAS, PlacedObject, RenderParameters, Share, views_of
from egad.learning.images.arrangement import TableGrasps
from egad.learning.images.rendering import Labelled
from egad_workflow.settings import Settings, select

SIDES = np.array([0.03, 0.06, 0.04])
AXES = np.vstack([np.eye(3), [[1.0, 0, 0]]])
WIDTHS = np.append(SIDES, 0.01)
QUALITIES = np.array([0.003, 0.004, 0.005, 0.006])


@pytest.fixture(scope="session")
def sets():
    """Pictures of a block by camera; a grasp across each pair of its sides, and a narrow one.

    The latter collides: the fingers would stand in the block. Of a block on a side, the grasp
    across that side is not reachable. The quality of a grasp tells its number.
    """

    def made(camera, **noise):
        changed = {"render": {"camera": camera}, "image_noise": noise}
        settings = select(Settings.model_validate(changed), RenderParameters, "egad_75mm")
        kinds = [("A1", "train")] * 4 + [("B2", "validation")] * 2 + [("C3", "test")] * 2
        shares = [
            Share(f"id-{name}", name, split, number, 1, "single", (name,))
            for number, (name, split) in enumerate(kinds)
        ]
        # lying on each of its sides, which is the one along this axis
        return [
            picture
            for share in shares
            for picture in views_of(labelled(share.first % 3), share, settings, (share.first,))
        ]

    return {name: made(name) for name in CAMERAS} | {"noisy": made("d435", missing=0.02)}


def labelled(upright):
    """The block with one of its axes upright, and its reachable grasps."""
    block = trimesh.creation.box(SIDES)
    matrix = np.eye(4)
    matrix[:3, :3] = np.roll(np.eye(3), 2 - upright, axis=0)
    matrix[2, 3] = SIDES[upright] / 2
    numbers = np.flatnonzero(np.abs(AXES[:, upright]) < 0.5)
    grasps = TableGrasps(
        objects=np.zeros(len(numbers), dtype=np.int64),
        centers=np.tile(matrix[:3, 3], (len(numbers), 1)),
        axes=AXES[numbers] @ matrix[:3, :3].T,
        widths=WIDTHS[numbers],
        free=numbers < 3,
        qualities=QUALITIES[numbers],
        success=np.full(len(numbers), None),
    )
    placed = PlacedObject("id-1", 1.0, block, np.zeros(3), matrix, upright)
    return Labelled((placed,), grasps, 1)


@pytest.fixture(scope="session")
def contacts():
    """From a picture to where the contacts of each of its grasps are in it, pixels, (n, 2, 2)."""

    def found(picture):
        to_camera = np.linalg.inv(picture.view.pose) @ picture.objects[0].matrix
        numbers = np.searchsorted(QUALITIES, picture.grasps.quality)
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

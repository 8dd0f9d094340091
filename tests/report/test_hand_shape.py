"""The hand at the best grasp: its fingers touch the contacts."""

import numpy as np
import pytest
import trimesh
from described_hands import box_urdf, linkage_mjcf

import egad
from egad.grippers import Gripper
from egad.report.hand_shape import LINK_COLORS, OBJECT_COLOR, best_grasp

BAR = trimesh.creation.box((0.03, 0.12, 0.12))  # only its first sides fit


@pytest.fixture(scope="module", params=["boxes", "sliding", "linkage"])
def hand(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("hand")
    return {
        "boxes": lambda: egad.gripper("yumi"),
        "sliding": lambda: Gripper.from_file(box_urdf(folder / "hand.urdf")),
        "linkage": lambda: Gripper.from_file(linkage_mjcf(folder / "hand.xml")),
    }[request.param]()


def test_fingers_are_on_both_sides_of_the_object_and_touch_it(hand):
    grasps = egad.sample_grasps(BAR, hand, n=20).to_frame()
    mesh, paint = best_grasp(BAR, grasps, hand)
    corners = [mesh.vertices[mesh.faces[paint == color]].reshape(-1, 3) for color in range(6)]
    np.testing.assert_allclose(np.ptp(corners[OBJECT_COLOR], axis=0), BAR.extents)
    first, second, palm = (corners[color] for color in map(LINK_COLORS.get, (-1, 1, 0)))
    best = grasps[grasps["collision_free"]].nlargest(1, "quality")
    start, end, approach = (
        best[[f"{name}_{axis}" for axis in "xyz"]].to_numpy()[0]
        for name in ("contact0", "contact1", "approach")
    )
    axis = (end - start) / np.linalg.norm(end - start)
    assert (first @ axis).max() == pytest.approx(start @ axis, abs=3e-4)
    assert (second @ axis).min() == pytest.approx(end @ axis, abs=3e-4)
    for finger in (first, second):
        assert (palm @ approach).max() < start @ approach < (finger @ approach).max()


def test_without_a_collision_free_grasp_there_is_no_hand():
    grasps = egad.sample_grasps(BAR, "yumi", n=5).to_frame().assign(collision_free=False)
    assert best_grasp(BAR, grasps, egad.gripper("yumi")) is None

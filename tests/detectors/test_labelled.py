"""labels proposes labelled grasps where the object lies, and only what the hand can do."""

import numpy as np
import pandas as pd
import pytest
import trimesh

from egad.bench import TrialProtocol, TrialRunner
from egad.detectors import DepthCamera, Intrinsics, camera_above
from egad.detectors.labels import Labels
from egad.geometry import Bundle
from egad.grippers import GRIPPERS
from egad.sim.arms import ARMS
from egad.sim.engines import open_world
from egad.sim.model import build

BUNDLE = Bundle()
HAND = GRIPPERS["egad_75mm"]
BOX = trimesh.creation.box(
    (0.03, 0.05, 0.09), trimesh.transformations.rotation_matrix(0.5, (1, 1, 0))
)
INTO_BOX = trimesh.transformations.rotation_matrix(0.5, (1, 1, 0))


def labelled(rows):
    """Grasps in the frame of the box's sides: center, axis, quality, free."""
    frame = []
    for center, axis, quality, free in rows:
        placed_center, placed_axis = INTO_BOX[:3, :3] @ center, INTO_BOX[:3, :3] @ axis
        frame.append(
            dict(zip(("center_x", "center_y", "center_z"), placed_center, strict=True))
            | dict(zip(("axis_x", "axis_y", "axis_z"), placed_axis, strict=True))
            | {
                "width": np.abs(axis) @ (0.03, 0.05, 0.09),
                "robust_quality": quality,
                "collision_free": free,
            }
        )
    return Labels(pd.DataFrame(frame))


SHORT, MIDDLE_SIDE, LONG = np.eye(3)
ALL = [
    ((0, 0, 0.01), SHORT, 0.002, True),
    ((0, 0, 0), SHORT, 0.004, True),
    ((0, 0, 0.02), SHORT, 0.009, False),
    ((0, 0, 0), MIDDLE_SIDE, 0.003, True),
]


def placed(up, turn=0.0):
    """The box stands with one of its axes up; its transform, and what is seen."""
    stand = trimesh.geometry.align_vectors(up, [0, 0, 1])
    spin = trimesh.transformations.rotation_matrix(turn, (0, 0, 1))
    matrix = spin @ stand @ INTO_BOX.T
    matrix[:3, 3] = (0.03, -0.02, -trimesh.transform_points(BOX.vertices, matrix)[:, 2].min())
    return matrix, DepthCamera(BOX).render(
        matrix, Intrinsics.spanning(300, 300, 40.0), camera_above(0.6)
    )


@pytest.mark.parametrize("turn", [0.0, 0.7, 2.5])
def test_grasps_move_with_the_object(turn):
    matrix, view = placed(LONG, turn)
    found = labelled(ALL).propose(matrix, view, HAND)
    assert [grasp.quality for grasp in found] == [0.004, 0.003, 0.002]
    np.testing.assert_allclose(found[0].center, (0.03, -0.02, 0.045), atol=1e-9)
    axis = matrix[:3, :3] @ INTO_BOX[:3, :3] @ SHORT
    assert abs(np.cos(found[0].angle) * axis[0] + np.sin(found[0].angle) * axis[1]) > 0.999
    assert found[0].tip == pytest.approx(0.035)
    assert all(grasp.infeasibility(HAND) is None for grasp in found)


def test_axes_that_stand_up_are_left_out():
    matrix, view = placed(SHORT)
    found = labelled(ALL).propose(matrix, view, HAND)
    assert [grasp.quality for grasp in found] == [0.003]


def test_fingers_stay_above_the_table_and_below_the_contacts():
    matrix, view = placed(MIDDLE_SIDE)
    low = [((0, -0.019, 0), SHORT, 0.004, True), ((0, -0.0245, 0), SHORT, 0.005, True)]
    (found,) = labelled(low).propose(matrix, view, HAND)
    assert found.quality == 0.004
    assert found.tip == pytest.approx(0.003)


def test_a_hand_opens_wide_to_reach_below_an_overhang():
    """A stem of 20 mm under a cap of 60 mm: half open, the fingers would land on the cap."""
    cap = trimesh.creation.box(bounds=[(-0.03, -0.03, 0.04), (0.03, 0.03, 0.05)])
    stem = trimesh.creation.box(bounds=[(-0.01, -0.01, 0), (0.01, 0.01, 0.04)])
    mushroom = trimesh.util.concatenate([cap, stem])
    view = DepthCamera(mushroom).render(
        np.eye(4), Intrinsics.spanning(300, 300, 40.0), camera_above(0.6)
    )
    row = {"center_x": 0, "center_y": 0, "center_z": 0.02, "axis_x": 1, "axis_y": 0, "axis_z": 0}
    row |= {"width": 0.02, "robust_quality": 0.004, "collision_free": True}
    (found,) = Labels(pd.DataFrame([row])).propose(np.eye(4), view, HAND)
    assert found.width == HAND.opening
    assert found.tip == pytest.approx(0.01)


def test_nothing_labelled_and_nothing_seen_give_nothing():
    matrix, view = placed(LONG)
    assert labelled([(*ALL[0][:3], False)]).propose(matrix, view, HAND) == []
    away = DepthCamera(BOX).render(np.eye(4) + np.eye(4, k=3) * 5, view.intrinsics, view.pose)
    assert labelled(ALL).propose(matrix, away, HAND) == []


def test_a_bench_tells_where_the_object_is():
    """The object is simulated in its principal frame, the grasps are in that of its mesh."""
    rows = [
        ((0, 0, z), axis, 0.004 - abs(z), True)
        for z in (-0.02, 0, 0.02)
        for axis in (SHORT, MIDDLE_SIDE)
    ]
    arm = ARMS["axis"](HAND)
    with open_world("mujoco", [build(BOX, 400.0, BUNDLE)], arm.robot) as world:
        runner = TrialRunner(world, arm, TrialProtocol())
        outcomes = [runner.attempt(labelled(rows), seed).outcome for seed in range(6)]
    assert outcomes.count("success") >= 5

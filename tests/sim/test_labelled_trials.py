"""Labelled grasps carried out: the hand comes as labelled, and physics decides what holds."""

import numpy as np
import pandas as pd
import pytest
import trimesh
from worlds import EACH_ENGINE, start

from egad.geometry import Bundle
from egad.grasps.poses import hand_poses
from egad.grippers import finger_span
from egad.sim.labelled_trials import (
    execute_labelled_grasps,
    failed_labelled_grasps,
    floating_pose,
    sample_labelled_grasps,
)
from egad.sim.model import build
from egad.sim.parameters import LabelTrialParameters
from egad.sim.world import DOWN, WEIGHTLESS
from egad.tables.columns import vector_names
from egad.tables.evaluation import AGREEMENT
from egad.tables.outcomes import Outcome
from egad_workflow.settings import Settings, select

SETTINGS = select(Settings(), LabelTrialParameters, "egad_75mm")
HAND = SETTINGS.gripper
SIDES = (0.03, 0.04, 0.06)
PLACE = trimesh.transformations.compose_matrix(angles=(0.4, 1.1, -2.0), translate=(0.1, 0.2, 0.3))
BOX = build(trimesh.creation.box(SIDES, PLACE), 1000.0, Bundle())
WEDGE = build(
    trimesh.convex.convex_hull(
        [(x, y, z) for x, z in ((-0.03, 0.0), (0.03, 0.0), (0.0, 0.04)) for y in (-0.02, 0.02)]
    ),
    1000.0,
    Bundle(),
)


def grasp(center, axis, approach, turn=PLACE, **known):
    """A row of the table of grasps, given in the frame of an upright object."""
    row = {
        "grasp": 0,
        "width": 0.03,
        "quality": 0.0,
        "robust_quality": 0.5,
        "robust_success_rate": 0.1,
        "collision_free": True,
    }
    for name, vector, free in (("center", center, 1), ("axis", axis, 0), ("approach", approach, 0)):
        row |= dict(zip(vector_names(name), turn @ [*vector, free], strict=False))
    return row | {"n_labelled": 9, "n_collision_free": 7} | known


def tried(model, *rows, engine="mujoco"):
    trials = SETTINGS.trials.model_copy(update={"engine": engine})
    settings = SETTINGS.model_copy(update={"trials": trials})
    return execute_labelled_grasps(model, "C4", "id", pd.DataFrame(rows), settings)


def test_the_object_floats_so_that_the_labelled_hand_points_down():
    row = grasp((0.005, 0.0, 0.01), (1, 0, 0), (0, 0.6, -0.8))
    pose, wanted = floating_pose(BOX, row, HAND)
    labelled = hand_poses(
        *(
            np.array([[row[n] for n in vector_names(part)]])
            for part in ("center", "axis", "approach")
        )
    )[0]
    world = pose.matrix @ BOX.to_principal @ labelled
    np.testing.assert_allclose(world[:3, 3], wanted.center, atol=1e-9)
    np.testing.assert_allclose(world[:3, 0], (1, 0, 0), atol=1e-9)
    np.testing.assert_allclose(world[:3, 2], (0, 0, -1), atol=1e-9)
    assert (wanted.angle, wanted.width) == (0.0, HAND.opening)
    assert wanted.depth == finger_span(HAND)[1]
    assert not wanted.infeasibility(HAND)
    with start("mujoco", BOX) as floating:
        floating.place(pose)
        assert floating.vertices()[:, 2].min() > 0.1


@EACH_ENGINE
@pytest.mark.parametrize("approach", [(0, 0, -1), (0, 0, 1), (0, 1, 0), (0, -0.6, 0.8)])
def test_a_box_is_held_by_its_middle_from_any_side(engine, approach):
    middle = grasp((0, 0, 0), (1, 0, 0), approach)
    (found,) = tried(BOX, middle, engine=engine).to_dict("records")
    assert found["outcome"] == "success"
    assert found["lifted"] == pytest.approx(SETTINGS.trials.lift_height, abs=0.003)


@EACH_ENGINE
def test_faces_beyond_the_friction_cone_slip_out_and_within_it_they_hold(engine):
    upright = np.eye(4)
    across = [grasp((0, 0, 0.03), axis, (0, 0, -1), upright) for axis in ((1, 0, 0), (0, 1, 0))]
    found = tried(WEDGE, *across, engine=engine)
    assert found["outcome"].str.startswith(("slipped", "missed")).tolist() == [True, False]
    assert found["success"].tolist() == [False, True]


@EACH_ENGINE
def test_what_is_in_the_way_is_a_collision(engine):
    aside = grasp((0.03, 0, 0), (1, 0, 0), (0, 0, -1))
    (found,) = tried(BOX, aside, engine=engine).to_dict("records")
    assert found["outcome"] == "collided"


@EACH_ENGINE
def test_no_grasp_depends_on_those_before(engine):
    rows = [
        grasp((0, 0, z), (1, 0, 0), (0, 0, -1), grasp=n) for n, z in enumerate((0, 0.02, 0.028))
    ]
    together = tried(BOX, *rows, engine=engine)
    apart = pd.concat([tried(BOX, row, engine=engine) for row in rows], ignore_index=True)
    pd.testing.assert_frame_equal(together, apart, check_exact=True)
    assert list(together.columns) == AGREEMENT.names


def test_the_sample_is_of_free_grasps_and_only_the_object_decides_it():
    table = pd.DataFrame([grasp((0, 0, 0), (1, 0, 0), (0, 0, 1), grasp=n) for n in range(50)])
    table["collision_free"] = table["grasp"] % 2 == 0
    found = sample_labelled_grasps(table, "id", 10, 0)
    assert len(found) == 10
    assert (found["grasp"] % 2 == 0).all()
    assert found["grasp"].is_monotonic_increasing
    assert found["grasp"].is_unique
    assert (found["n_labelled"] == 50).all()
    assert (found["n_collision_free"] == 25).all()
    pd.testing.assert_frame_equal(found, sample_labelled_grasps(table, "id", 10, 0))
    assert (
        sample_labelled_grasps(table, "other", 10, 0)["grasp"].tolist() != found["grasp"].tolist()
    )
    assert len(sample_labelled_grasps(table, "id", 99, 0)) == 25
    assert len(sample_labelled_grasps(table.head(0), "id", 10, 0)) == 0


def test_an_object_without_a_model_has_its_grasps_marked():
    sample = pd.DataFrame([grasp((0, 0, 0), (1, 0, 0), (0, 0, 1))])
    table = failed_labelled_grasps("C4", "id", sample, SETTINGS, Outcome.FAILED)
    assert table["outcome"].tolist() == ["failed"]
    assert not table["success"].any()
    assert list(table.columns) == AGREEMENT.names


@EACH_ENGINE
def test_a_pinned_object_stays_and_falls_when_let_go(engine):
    with start(engine, BOX) as world:
        world.place(floating_pose(BOX, grasp((0, 0, 0), (1, 0, 0), (0, 0, -1)), HAND)[0])
        before = world.pose()
        with world.pinned():
            world.step(120)
        np.testing.assert_allclose(world.pose().position, before.position, atol=1e-4)
        world.set_gravity(WEIGHTLESS)
        world.step(60)
        np.testing.assert_allclose(world.pose().position, before.position, atol=1e-3)
        world.set_gravity(DOWN)
        world.step(24)
        assert world.pose().position[2] < before.position[2] - 0.03

"""Naive grasps: where they come from is uniform, and what becomes of them is known for balls."""

import numpy as np
import pandas as pd
import pytest
import trimesh
from scipy.spatial.transform import Rotation
from scipy.stats import chisquare, kstest
from worlds import EACH_FAST_ENGINE, HAND

from egad.bench import NaiveGrasp, NaiveGraspParameters, naive_grasps, try_naive_grasps
from egad.bench.naive_grasps import (
    Touch,
    approach_pose,
    sample_pose,
    sample_touch,
    try_in_free_space,
    try_on_table,
)
from egad.geometry import Bundle
from egad.grasps import Quality
from egad.grippers import finger_span
from egad.random import generator
from egad.sim.arms import TurningAxis
from egad.sim.engines import open_world
from egad.sim.model import Model, build
from egad.sim.parameters import Lifting, SimulatedLabel
from egad.sim.robots import free_hand
from egad.sim.world import UnstableError
from egad.tables.outcomes import Outcome

SIDES = np.array([0.01, 0.02, 0.04])
BOX = trimesh.creation.box(SIDES)
ALL = np.ones(len(BOX.faces), dtype=bool)
COUNT = 1000
RADIUS = 0.02


def ball(radius: float) -> Model:
    return build(trimesh.creation.icosphere(subdivisions=3, radius=radius), 400, Bundle())


BALL = ball(RADIUS)


def parameters(grasps=6, engine="mujoco", seed=0):
    return NaiveGraspParameters(
        seed=seed,
        gripper=HAND,
        quality=Quality(),
        trials=Lifting(),
        simulated_label=SimulatedLabel(engine=engine),
        naive_grasp=NaiveGrasp(grasps=grasps),
    )


def tip_of(pose):
    return pose[:3, 3] + finger_span(HAND)[1] * pose[:3, 2]


def poses(mesh, count=COUNT, rest=None, **limits):
    rng = np.random.default_rng(0)
    return np.array([sample_pose(mesh, HAND, rng, rest, **limits) for _ in range(count)])


def test_points_lie_on_the_surface_uniformly_by_area():
    """On each face of a box as often as its area says, and anywhere on it."""
    rng = np.random.default_rng(0)
    touches = [sample_touch(BOX, ALL, rng) for _ in range(COUNT)]
    points, normals = (
        np.array([getattr(each, name) for each in touches]) for name in Touch._fields
    )
    axes, outward = np.nonzero(normals)[1], normals.sum(axis=1)
    rows = np.arange(COUNT)
    np.testing.assert_allclose(points[rows, axes], outward * SIDES[axes] / 2, atol=1e-12)
    assert (np.abs(points) <= SIDES / 2 + 1e-12).all()
    area = np.repeat([SIDES[1] * SIDES[2], SIDES[0] * SIDES[2], SIDES[0] * SIDES[1]], 2)
    found = np.bincount(2 * axes + (outward > 0), minlength=6)
    assert chisquare(found, COUNT * area / area.sum()).pvalue > 0.001
    on_largest = points[axes == 0]
    for axis in (1, 2):
        assert kstest(on_largest[:, axis] / SIDES[axis] + 0.5, "uniform").pvalue > 0.001


@pytest.mark.parametrize("normal", [*np.eye(3), *-np.eye(3), np.array([0.6, 0.0, 0.8])])
def test_the_hand_comes_against_the_normal_as_deep_as_asked(normal):
    pose = approach_pose(Touch(np.array([0.1, 0.2, 0.3]), normal), 0.7, 0.015, HAND)
    np.testing.assert_allclose(pose[:3, :3].T @ pose[:3, :3], np.eye(3), atol=1e-12)
    assert np.linalg.det(pose[:3, :3]) == pytest.approx(1)
    np.testing.assert_allclose(pose[:3, 2], -normal, atol=1e-12)
    np.testing.assert_allclose(tip_of(pose), [0.1, 0.2, 0.3] - 0.015 * normal, atol=1e-12)
    further = approach_pose(Touch(np.zeros(3), normal), 1.2, 0.0, HAND)
    assert pose[:3, 0] @ further[:3, 0] == pytest.approx(np.cos(0.5))


def test_turn_and_depth_are_uniform():
    """Of hands that come to the top of a box: the direction of the fingers, and their height."""
    found = poses(BOX)
    top = found[found[:, 2, 2] < -0.5]
    assert len(top) > 60
    turns = np.arctan2(top[:, 1, 0], top[:, 0, 0]) % np.pi
    assert kstest(turns / np.pi, "uniform").pvalue > 0.001
    depths = np.array([SIDES[2] / 2 - tip_of(pose)[2] for pose in top])
    assert kstest(depths / HAND.finger_length, "uniform").pvalue > 0.001
    shallow = poses(BOX, 200, deepest=0.01)
    surface = np.abs(SIDES / 2 @ np.abs(shallow[:, :3, 2]).T)
    below = surface + np.array([tip_of(pose) @ pose[:3, 2] for pose in shallow])
    assert 0 <= below.min() < 0.001
    assert 0.009 < below.max() <= 0.01


def test_on_a_table_the_hand_comes_from_above_and_stays_above():
    """To the top of a box that is tilted by 20 degrees; its next face is by 70."""
    rest = np.eye(4)
    rest[:3, :3] = Rotation.from_euler("x", 20, degrees=True).as_matrix()
    rest[:3, 3] = [0.1, -0.2, 0.03]
    found = poses(BOX, rest=rest)
    tilts = np.degrees(np.arccos(-found[:, 2, 2]))
    assert set(tilts.round(6)) == {20.0}
    tips = np.array([tip_of(pose) for pose in found])
    assert tips[:, 2].min() >= 0.003 - 1e-12
    back = (tips - rest[:3, 3]) @ rest[:3, :3]
    assert (np.abs(back[:, :2]) <= SIDES[:2] / 2 + 1e-12).all()
    assert kstest(back[:, 0] / SIDES[0] + 0.5, "uniform").pvalue > 0.001


def test_nothing_faces_up_on_a_needle():
    needle = trimesh.creation.cone(radius=0.01, height=0.1)
    assert sample_pose(needle, HAND, np.random.default_rng(0), np.eye(4)) is None
    assert sample_pose(needle, HAND, np.random.default_rng(0)) is not None


@EACH_FAST_ENGINE
def test_a_ball_is_held_whenever_the_fingertips_pass_its_middle(engine):
    """Every hand comes along a diameter; with too little depth the pads slide off, or miss."""
    arm = TurningAxis(HAND)
    deep, shallow = [], []
    with open_world(engine, [BALL], arm.robot) as world:
        for number in range(30):
            pose = sample_pose(BALL.mesh, HAND, generator(0, "ball", number))
            depth = RADIUS + tip_of(pose) @ pose[:3, 2]
            outcome = try_in_free_space(world, arm, Lifting(), generator(0, "ball", number))
            if depth > RADIUS + 0.005:
                deep.append(outcome)
            elif depth < 0.002:
                shallow.append(outcome)
    assert len(deep) > 12
    assert np.mean([each == Outcome.SUCCESS for each in deep]) >= 0.95
    assert shallow
    assert Outcome.SUCCESS not in shallow


@EACH_FAST_ENGINE
def test_a_ball_on_a_table_is_held_at_times_and_the_hand_collides_at_others(engine):
    with open_world(engine, [BALL], free_hand(HAND)) as world:
        found = {try_on_table(world, generator(0, "ball", number)) for number in range(16)}
    assert {Outcome.SUCCESS, Outcome.COLLIDED} <= found


def test_a_grasp_does_not_depend_on_what_was_tried_before():
    box = build(trimesh.creation.box((0.03, 0.04, 0.05)), 400, Bundle())
    objects = {"box": box, "ball": BALL}
    first = {name: try_naive_grasps(objects[name], name, parameters()) for name in objects}
    for name in reversed(objects):
        again = try_naive_grasps(objects[name], name, parameters())
        pd.testing.assert_frame_equal(again, first[name])
    assert first["box"]["place"].tolist() == ["free"] * 6 + ["table"] * 6
    fewer = try_naive_grasps(box, "box", parameters(grasps=3))
    same = first["box"][first["box"]["number"] < 3].reset_index(drop=True)
    pd.testing.assert_frame_equal(fewer, same)


def test_a_simulation_that_goes_wrong_is_an_outcome(monkeypatch):
    def explode(*_):
        raise UnstableError

    monkeypatch.setattr(naive_grasps, "make_scene", explode)
    found = try_naive_grasps(BALL, "ball", parameters(2))
    assert found["outcome"].tolist()[2:] == ["failed"] * 2
    assert "failed" not in found["outcome"].tolist()[:2]

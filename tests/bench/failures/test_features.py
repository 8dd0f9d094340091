"""Features of shape against solids whose numbers are known, and shares against a slow count."""

import math

import numpy as np
import pandas as pd
import pytest
import trimesh
from partial_tables import fill_columns
from scipy.spatial.transform import Rotation

import egad
from egad.bench.failures import SHAPE_FEATURES, shape_features, shares
from egad.bench.failures.features import (
    asymmetry,
    concavity,
    contact_points,
    held_grasps,
    patch_curvature,
    wall_thickness,
)
from egad.detectors import Grasp
from egad.geometry import Material, RayCaster
from egad.sim import build
from egad.tables.failures import FAILURE_ATTEMPTS

PANDA = egad.gripper("panda")
SIDES = (0.03, 0.04, 0.06)


def sampled(mesh):
    points, faces = trimesh.sample.sample_surface(mesh, 20_000, seed=1)
    return points, RayCaster(mesh).normals[faces]


def grasp_along(axis, approach, center=(0, 0, 0), width=0.08):
    pose = np.eye(4)
    pose[:3, 0], pose[:3, 2], pose[:3, 3] = axis, approach, center
    pose[:3, 1] = np.cross(approach, axis)
    return Grasp.of_pose(pose, width, 1.0)


def attempts_of(mesh, grasps, success=True):
    """Rows of grasps in the frame of a mesh, of an object that lies anyhow."""
    to_principal = build(mesh, Material().density, egad.geometry.Bundle()).to_principal
    rest = np.eye(4)
    turn = Rotation.from_euler("xyz", [0.3, -0.7, 2.0])
    rest[:3, :3], rest[:3, 3] = turn.as_matrix(), (0.1, -0.05, 0.03)
    place = dict(zip(("x", "y", "z"), rest[:3, 3], strict=True))
    place |= dict(zip(("qx", "qy", "qz", "qw"), turn.as_quat(), strict=True))
    return fill_columns(
        FAILURE_ATTEMPTS,
        [
            {f"rest_{name}": value for name, value in place.items()}
            | {
                "success": success,
                "pose": (rest @ to_principal @ grasp.pose)[:3].ravel().tolist(),
                "width": grasp.width,
            }
            for grasp in grasps
        ],
    )


def test_contacts_of_a_box_lie_on_its_sides():
    box = trimesh.creation.box(SIDES)
    for axis, side in zip(np.eye(3), SIDES, strict=True):
        approach = np.roll(axis, 1)
        first, second = contact_points(RayCaster(box), grasp_along(axis, approach), PANDA)
        assert first @ axis == pytest.approx(-side / 2)
        assert second @ axis == pytest.approx(side / 2)


def test_a_cup_has_one_contact():
    cup = next(g for name in egad.grippers.GRIPPERS if (g := egad.gripper(name)).cup)
    ball = trimesh.creation.icosphere(subdivisions=4, radius=0.03)
    down = grasp_along((1, 0, 0), (0, 0, -1), (0, 0, 0.03))
    (contact,) = contact_points(RayCaster(ball), down, cup)
    np.testing.assert_allclose(contact, (0, 0, 0.03), atol=1e-4)


def test_grasps_come_back_into_the_frame_of_the_mesh():
    mesh = trimesh.creation.box(SIDES).apply_translation((0.2, 0.1, -0.3))
    given = [grasp_along((0, 1, 0), (1, 0, 0), (0.2, 0.1, -0.29))]
    (found,) = held_grasps(mesh, attempts_of(mesh, given))
    np.testing.assert_allclose(found.pose, given[0].pose, atol=1e-9)
    assert held_grasps(mesh, attempts_of(mesh, given, success=False)) == []


@pytest.mark.parametrize("radius", [0.015, 0.03])
def test_curvature_of_a_ball_is_one_over_its_radius(radius):
    ball = trimesh.creation.icosphere(subdivisions=5, radius=radius)
    found = patch_curvature(*sampled(ball), np.array([0, 0, radius]))
    assert found == pytest.approx(1 / radius, rel=0.05)


def test_curvature_is_nothing_on_a_plane_and_ignores_the_other_side_of_a_wall():
    plate = trimesh.creation.box((0.06, 0.06, 0.002))
    points, normals = sampled(plate)
    assert patch_curvature(points, normals, np.array([0, 0, 0.001])) == pytest.approx(0, abs=1e-6)
    corner = np.array([0.03, 0.0, 0.001])
    # Half a disc of the top, and a band of the side at right angles.
    assert patch_curvature(points, normals, corner) > 150


def test_thickness_of_a_plate_and_of_a_shell():
    plate = trimesh.creation.box((0.06, 0.06, 0.002))
    assert wall_thickness(RayCaster(plate), *sampled(plate)) == pytest.approx(0.002)
    tube = trimesh.creation.annulus(r_min=0.02, r_max=0.023, height=0.08, sections=128)
    found = wall_thickness(RayCaster(tube), *sampled(tube))
    assert found == pytest.approx(0.003, rel=0.02)


def test_concavity_is_the_share_of_the_hull_that_is_missing():
    assert concavity(trimesh.creation.box(SIDES)) == pytest.approx(0, abs=1e-9)
    arms = [trimesh.creation.box(bounds=[(0, 0, 0), far]) for far in ((2, 1, 1), (1, 2, 1))]
    angle = trimesh.boolean.union(arms, engine="manifold")
    assert concavity(angle) == pytest.approx(1 - 3 / 3.5)


def test_asymmetry_agrees_with_exact_volumes(lumpy):
    mesh = lumpy.copy().apply_scale((0.03, 0.04, 0.06))
    placed = build(mesh, Material().density, egad.geometry.Bundle()).mesh
    expected = []
    for axis in range(3):
        image = placed.copy()
        image.vertices[:, axis] *= -1
        image.invert()
        common = trimesh.boolean.intersection([placed, image], engine="manifold")
        expected.append(1 - common.volume / placed.volume)
    assert min(expected) > 0.01
    assert asymmetry(mesh) == pytest.approx(min(expected), abs=0.01)


def test_features_of_a_box():
    box = trimesh.creation.box(SIDES)
    attempts = attempts_of(box, [grasp_along((0, 1, 0), (1, 0, 0))] * 3)
    found = shape_features(box, attempts, PANDA)
    assert found["grasp_size"] == pytest.approx(0.04 / PANDA.opening)
    assert found["wall_thickness"] == pytest.approx(0.03)
    assert found["concavity"] == pytest.approx(0, abs=1e-9)
    assert set(found) | {"complexity", "graspability"} == set(SHAPE_FEATURES)


def test_features_at_the_grasp_are_unknown_without_a_grasp():
    box = trimesh.creation.box(SIDES)
    found = shape_features(box, fill_columns(FAILURE_ATTEMPTS, [{"id": "x"}]), PANDA)
    assert math.isnan(found["grasp_size"])
    assert math.isnan(found["contact_curvature"])
    assert found["wall_thickness"] == pytest.approx(0.03)


def test_shares_are_what_lies_outside_the_range():
    rng = np.random.default_rng(0)
    solved = pd.DataFrame({"thin": rng.normal(size=200), "same": rng.normal(size=200)})
    failures = pd.DataFrame(
        {"thin": rng.normal(-4, 1, size=60), "same": rng.choice(solved["same"], size=60)}
    )
    found = shares(failures, solved)
    for name, each in found.items():
        low, high = np.quantile(solved[name], 0.05), np.quantile(solved[name], 0.95)
        below = sum(value < low for value in failures[name]) / 60
        above = sum(value > high for value in failures[name]) / 60
        assert (each.low, each.high, each.below, each.above) == (low, high, below, above)
        assert each.value == pytest.approx(below + above - 0.1)
        assert each.ci_low <= each.value <= each.ci_high
    assert found["thin"].ci_low > 0.7
    assert found["same"].ci_low < 0 < found["same"].ci_high


def test_intervals_agree_with_a_slow_bootstrap():
    rng = np.random.default_rng(1)
    solved, failures = rng.normal(size=80), rng.normal(1.5, 1, size=40)
    table = [pd.DataFrame({"x": values}) for values in (failures, solved)]
    found = shares(*table)["x"]
    everything = np.concatenate([failures, solved])
    values = []
    for _ in range(3000):
        drawn = rng.integers(120, size=120)
        out, inner = everything[drawn[drawn < 40]], everything[drawn[drawn >= 40]]
        low, high = np.quantile(inner, [0.05, 0.95])
        values.append(((out < low) | (out > high)).mean() - 0.1)
    low, high = np.quantile(values, [0.025, 0.975])
    assert found.ci_low == pytest.approx(low, abs=0.03)
    assert found.ci_high == pytest.approx(high, abs=0.03)


def test_few_failures_within_the_range_leave_room():
    solved = pd.DataFrame({"x": np.linspace(0, 1, 100)})
    found = shares(pd.DataFrame({"x": [0.5, 0.6, 0.4]}), solved)["x"]
    assert found.value == pytest.approx(-0.1)
    assert found.ci_high > 0.4  # none of three may be one of two

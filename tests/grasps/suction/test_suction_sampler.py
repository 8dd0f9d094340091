import re

import numpy as np
import pandas as pd
import pytest
import trimesh
from cup_shapes import DOWN, box
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation
from scipy.stats import chisquare

from egad.errors import RejectedError, UserError
from egad.geometry import RayCaster
from egad.grasps import RobustSuction, vectors
from egad.grasps.suction import collision_free, sample_suction, suction_poses
from egad.grasps.suction.seal import SealFailure
from egad.grippers import SuctionCup

SMALL = SuctionCup(radius=0.006, height=0.012)
RESULTS = ["sealed", "seal_failure", "resists", "collision_free"]


@pytest.fixture(scope="module")
def mug():
    """A mug of 80 mm with a handle, closed."""
    wall = trimesh.creation.cylinder(0.04, 0.09, sections=48)
    room = trimesh.creation.cylinder(0.036, 0.09, sections=48).apply_translation([0, 0, 0.005])
    handle = trimesh.creation.torus(0.025, 0.006, major_sections=32, minor_sections=16)
    handle.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [1, 0, 0]))
    handle.apply_translation([0.045, 0, 0])
    outside = trimesh.boolean.union([wall, handle], engine="manifold")
    return trimesh.boolean.difference([outside, room], engine="manifold")


@pytest.fixture(scope="module")
def grasps(mug):
    return sample_suction(mug, SMALL, 100, seed=3)


def test_the_table_is_consistent(grasps):
    assert len(grasps) == 100
    assert (grasps["sealed"] == (grasps["seal_failure"] == "")).all()
    assert not (grasps["resists"] & ~grasps["sealed"]).any()
    assert set(grasps["seal_failure"]) <= {"", *SealFailure}
    assert grasps["sealed"].sum() > 20
    assert grasps["quality"].between(0, 1).all()
    assert grasps["quality"][grasps["resists"]].mean() > 1.5 * grasps["quality"].mean()
    assert (grasps["strain"][grasps["sealed"]] < SMALL.max_strain).all()
    assert 0 < grasps["collision_free"].sum() < 100


def test_cups_stand_on_the_surface_and_look_inwards(mug, grasps):
    poses = suction_poses(grasps)
    rotations = poses[:, :3, :3]
    identity = np.einsum("nij,nik->njk", rotations, rotations)
    assert_allclose(identity, np.tile(np.eye(3), (100, 1, 1)), atol=1e-12)
    assert_allclose(np.linalg.det(poses), 1)
    back = -vectors(grasps, "approach")
    points = vectors(grasps, "point")
    hits = RayCaster(mug).first_hits(points + 0.001 * back, -back)
    assert_allclose(hits.distances, 0.001, atol=1e-9)
    assert_allclose(hits.normals, back, atol=1e-12)


def test_points_are_uniform_by_area():
    sides = np.array([0.04, 0.06, 0.09])
    found = sample_suction(
        trimesh.creation.box(sides), SMALL, 3000, robust=RobustSuction(samples=1)
    )
    axis = np.abs(vectors(found, "approach")).argmax(axis=1)
    assert chisquare(np.bincount(axis), 3000 / sides / (1 / sides).sum()).pvalue > 0.001
    top = found[(axis == 2)]
    counts, *_ = np.histogram2d(top["point_x"], top["point_y"], bins=(4, 6))
    assert chisquare(counts.ravel()).pvalue > 0.001
    turns = np.arctan2(top["axis_y"], top["axis_x"])
    assert chisquare(np.histogram(turns, bins=8, range=(-np.pi, np.pi))[0]).pvalue > 0.001


def test_the_same_seed_gives_the_same_grasps_however_many(mug, grasps):
    pd.testing.assert_frame_equal(sample_suction(mug, SMALL, 100, seed=3), grasps)
    few = sample_suction(mug, SMALL, 37, seed=3)
    pd.testing.assert_frame_equal(few, grasps[:37])
    assert not sample_suction(mug, SMALL, 100, seed=4)["point_x"].equals(grasps["point_x"])


def test_a_moved_mesh_has_the_same_grasps_moved(mug, grasps):
    turn, shift = Rotation.from_rotvec([0.4, -0.9, 1.3]), np.array([0.2, -0.1, 0.3])
    moved = trimesh.Trimesh(turn.apply(np.array(mug.vertices)) + shift, mug.faces, process=False)
    found = sample_suction(moved, SMALL, 100, seed=3)
    assert_allclose(vectors(found, "point"), turn.apply(vectors(grasps, "point").copy()) + shift)
    for name in ("approach", "axis"):
        assert_allclose(vectors(found, name), turn.apply(vectors(grasps, name).copy()), atol=1e-9)
    pd.testing.assert_frame_equal(found[RESULTS], grasps[RESULTS])
    assert_allclose(found["quality"], grasps["quality"])
    assert_allclose(found["strain"], grasps["strain"], atol=1e-6)


def test_the_weight_is_that_of_the_object():
    """A cup on a face of a cube of 60 mm: 86 g at 400 kg/m3."""
    mesh, weak = box(), SMALL.model_copy(update={"vacuum_force": 0.86})
    lifted = sample_suction(mesh, weak, 50)
    assert lifted["resists"].equals(lifted["sealed"])  # 0.848 N
    heavy = sample_suction(mesh, weak, 50, density=410)
    assert heavy["sealed"].equals(lifted["sealed"])
    assert not heavy["resists"].any()
    given = sample_suction(mesh, weak, 50, density=410, mass=0.0864)
    assert given["resists"].equals(lifted["resists"])


def test_the_lever_of_the_center_of_mass_counts():
    """1 N hangs at most 31.8 mm beside the axis of a 30 mm cup."""
    mesh = trimesh.creation.box([0.2, 0.05, 0.02])
    for com in ((0, 0, 0), (0.03, 0, 0)):
        found = sample_suction(mesh, SuctionCup(), 400, mass=1 / 9.81, center_of_mass=com)
        flat = found[found["sealed"] & (found["approach_z"].abs() > 0.9)]
        lever = np.hypot(flat["point_x"] - com[0], flat["point_y"])
        assert (flat["resists"] == (lever < 0.0318)).mean() > 0.98
        assert 0 < flat["resists"].sum() < len(flat)


@pytest.mark.parametrize(
    ("shift", "free"),
    [
        ((0.013, 0, 0.035), False),  # beside the axis, within the way of the ring
        ((0.020, 0, 0.035), True),  # beside the ring
        ((0.013, 0, 0.2), False),  # on the way in, 200 mm above the top of the cup at most
        ((0.013, 0, 0.26), True),
    ],
)
def test_cups_come_in_without_a_collision(shift, free):
    """A small cube hangs above the face of a large one."""
    small = box(0.004).apply_translation(np.array([0, 0, 0.03]) + shift)
    caster = RayCaster(trimesh.util.concatenate([box(), small]))
    origins = np.array([[0, 0, 0.03]])
    cup = SuctionCup(approach=0.2)
    depths = np.zeros(1)
    assert collision_free(caster, cup, origins, DOWN[None], depths).tolist() == [free]
    thick = cup.model_copy(update={"stem_radius": 0.03})
    clear = collision_free(caster, thick, origins, DOWN[None], depths)
    assert clear.tolist() == [False]


def test_the_stem_follows_the_depth_of_the_ring():
    """A pin as high as the cup is hit once the ring lies deeper."""
    pin = trimesh.creation.cylinder(0.001, 0.0295).apply_translation([0, 0, 0.03 + 0.0295 / 2])
    caster = RayCaster(trimesh.util.concatenate([box(), pin]))
    origins, frames = np.array([[0, 0, 0.03]] * 3), np.stack([DOWN] * 3)
    found = collision_free(caster, SuctionCup(), origins, frames, np.array([0, 0.001, np.inf]))
    assert found.tolist() == [True, False, True]


@pytest.mark.parametrize(
    ("mesh", "message"),
    [
        (box(0.02), "the cup, 30 mm across, is larger than the object of 20 x 20 x 20 mm"),
        (
            trimesh.creation.annulus(r_min=0.004, r_max=0.0163, height=0.01),
            r"no cup seals \(of 20 candidates: .*ring misses the object \(\d+\)",
        ),
        (trimesh.creation.icosphere(radius=0.012), "larger than the object of"),
    ],
)
def test_an_object_without_grasps_is_refused_with_the_reason(mesh, message):
    with pytest.raises(RejectedError, match=message):
        sample_suction(mesh, n=20)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"n": 0}, "n is 0; allowed: a whole number, at least 1"),
        ({"mass": 0}, "mass is 0; allowed: a finite number, above 0"),
        ({"gravity": (0, 0, 0)}, "gravity is (0, 0, 0); allowed: a nonzero direction"),
    ],
)
def test_wrong_arguments_are_named(wrong, message):
    with pytest.raises(UserError, match=re.escape(message)):
        sample_suction(box(), **wrong)

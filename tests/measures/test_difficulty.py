import numpy as np
import pytest
import trimesh

from egad.errors import RejectedError
from egad.measures.difficulty import center_of_mass, difficulty, percentile, percentile_std
from egad.measures.parameters import MeasureParameters
from egad.pipeline.config import Settings
from egad.pipeline.config.stage_settings import select


def measure(mesh, grasps=100, seed=0, com=None, sampling=None, **settings):
    config = {"difficulty": settings, "sampling": sampling or {}}
    read = select(Settings.model_validate(config), MeasureParameters)
    return difficulty(mesh, read, grasps, np.random.default_rng(seed), com)


def wedge():
    """An irregular solid: the hull of random points."""
    return trimesh.convex.convex_hull(np.random.default_rng(0).normal(size=(12, 3)) * [1, 1.5, 2])


@pytest.mark.parametrize(
    ("values", "percent", "expected"),
    [
        (range(100), 75, 75),  # the 76th smallest
        ([3, 1, 2], 75, 3),
        ([5, 0, 0, 0], 75, 5),
        ([5, 0, 0, 0], 74, 0),
        ([7], 0, 7),
        ([7, 8], 100, 8),
    ],
)
def test_percentile_is_a_plain_index(values, percent, expected):
    assert percentile(np.array(values, dtype=float), percent) == expected


@pytest.mark.parametrize("percent", [25, 75])
def test_the_standard_error_is_the_spread_of_resampled_values(percent):
    """It is the limit of the bootstrap for infinitely many resamples."""
    rng = np.random.default_rng(percent)
    values = rng.gamma(2, size=40)
    resampled = np.sort(rng.choice(values, (40_000, 40)), axis=1)
    spread = resampled[:, 40 * percent // 100].std()
    assert percentile_std(values, percent) == pytest.approx(spread, rel=0.02)


def test_the_standard_error_is_the_spread_of_repeated_samples():
    rng = np.random.default_rng(0)
    samples = np.sort(rng.gamma(2, size=(4000, 200)), axis=1)
    spread = samples[:, 150].std()
    told = np.mean([percentile_std(sample, 75) for sample in samples[:300]])
    assert told == pytest.approx(spread, rel=0.1)


def test_value_of_a_ball_and_of_a_slab():
    ball, _, used = measure(trimesh.creation.icosphere(subdivisions=4))
    slab, *_ = measure(trimesh.creation.box([0.04, 0.1, 0.1]))
    assert used == 100
    assert ball == pytest.approx(0.0036, abs=0.0003)
    assert slab == pytest.approx(0.0013, abs=0.0003)


def test_unit_does_not_matter():
    mesh = wedge()
    large = trimesh.Trimesh(mesh.vertices * 1024, mesh.faces, process=False)
    assert measure(mesh) == measure(large)


def test_place_and_pose_matter_no_more_than_chance():
    mesh = wedge()
    turned = mesh.copy()
    turned.apply_transform(trimesh.transformations.rotation_matrix(2.0, [0.2, 0.7, 0.4]))
    turned.apply_translation([3, -2, 1])
    assert measure(turned, 2000)[0] == pytest.approx(measure(mesh, 2000)[0], abs=1e-4)


def test_a_given_center_of_mass_moves_with_the_mesh():
    box = trimesh.creation.box([0.04, 0.04, 0.2])
    box.apply_transform(trimesh.transformations.rotation_matrix(1.0, [0.3, 0.6, 0.9]))
    box.apply_translation([1, 2, 3])
    assert measure(box, com=box.center_mass)[0] == pytest.approx(measure(box)[0], rel=1e-6)
    end = box.vertices[0]
    assert measure(box, com=end)[0] < 0.8 * measure(box)[0]


def test_side_fraction_sets_the_size():
    mesh = wedge()
    assert measure(mesh, side_fraction=0.3)[0] > measure(mesh, side_fraction=0.8)[0]


def test_fewer_grasps_than_wanted_are_counted():
    value, _, used = measure(wedge(), sampling={"rounds": 1, "spacing": 0.01})
    assert 0 < used < 100
    assert value > 0


def test_the_robust_metric_is_lower_for_objects_as_wide_as_the_hand():
    ball = trimesh.creation.icosphere(subdivisions=3)
    plain, *_ = measure(ball)
    robust, _, used = measure(ball, metric="robust")
    assert used == 100
    assert 0 < robust < plain


def test_same_seed_gives_the_same_value():
    assert measure(wedge()) == measure(wedge())
    assert measure(wedge()) != measure(wedge(), seed=1)


def test_center_of_mass_of_an_open_surface_is_within_its_bounds():
    sheet = trimesh.creation.icosphere(subdivisions=2)
    sheet.update_faces(sheet.triangles_center[:, 2] > 0)
    sheet.apply_translation([0, 0, -0.9])
    center = center_of_mass(sheet)
    assert (center >= sheet.bounds[0]).all()
    assert (center <= sheet.bounds[1]).all()


def test_inside_out_mesh_is_rejected():
    mesh = wedge()
    mesh.invert()
    with pytest.raises(RejectedError, match=r"no grasp \(of 2000 candidates"):
        measure(mesh)


@pytest.mark.parametrize(
    ("vertices", "faces", "reason"),
    [
        (np.zeros((3, 3)), np.empty((0, 3), dtype=int), "no faces"),
        (np.eye(3) * np.nan, [[0, 1, 2]], "not finite"),
        (np.eye(3), [[0, 1, 2]], "flat"),
        (np.zeros((3, 3)), [[0, 1, 2]], "flat"),
    ],
)
def test_useless_meshes_are_rejected(vertices, faces, reason):
    with pytest.raises(RejectedError, match=reason):
        measure(trimesh.Trimesh(vertices, faces, process=False))

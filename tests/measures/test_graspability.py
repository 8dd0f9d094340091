import numpy as np
import pytest
import trimesh

from egad.errors import RejectedError
from egad.geometry import center_of_mass
from egad.geometry.rays import RayCaster
from egad.grasps import join, sample_contacts, valid_contacts
from egad.grasps.quality import ferrari_canny
from egad.measures.graspability import (
    _apply,
    _principal_box,
    graspability,
    rough_graspability,
    spaced_graspability,
)
from egad.measures.grid import graspability_limits
from egad.measures.parameters import MeasureParameters
from egad.measures.percentile import BoundedSample, confidence_between, percentile, percentile_std
from egad_workflow.settings import Settings, select


def parameters(sampling=None, confidence=0.0, **settings):
    config = {
        "graspability": settings,
        "sampling": sampling or {},
        "space": {"confidence": confidence},
    }
    return select(Settings.model_validate(config), MeasureParameters)


def measure(mesh, candidates=512, seed=0, com=None, factor=None, **settings):
    read = parameters(candidates=candidates, **settings)
    return graspability(mesh, read, candidates, np.random.default_rng(seed), com, factor)


def wedge():
    """An irregular solid: the hull of random points."""
    return trimesh.convex.convex_hull(np.random.default_rng(0).normal(size=(12, 3)) * [1, 1.5, 2])


def aligned(mesh, settings):
    middle, axes, extents = _principal_box(mesh.vertices)
    return middle, axes * (0.8 * settings.gripper.opening / extents.min())


def every_quality(mesh, settings, candidates, rng, com):
    """All qualities of all grasps, as the sampler gives them after any number of rounds."""
    place = aligned(mesh, settings)
    scaled = trimesh.Trimesh(_apply(place, mesh.vertices), mesh.faces, process=False)
    caster, parts = RayCaster(scaled), []
    for count in candidates:
        found, _ = valid_contacts(caster, settings.gripper.opening, count, settings.sampling, rng)
        parts.append(found)
    every = join(parts)
    return ferrari_canny(every.points, every.normals, every.axes, _apply(place, com))


@pytest.mark.parametrize("number", range(4))
def test_equals_the_exhaustive_estimate(spiky_box, number):
    """Exact qualities of all grasps give the same value, error and confidence."""
    mesh = spiky_box(number)
    settings = parameters(confidence=1.0, candidates=100)
    found = graspability(mesh, settings, 800, np.random.default_rng(5), mesh.center_mass)
    rng = np.random.default_rng(5)
    values = every_quality(mesh, settings, (100, 100, 200, 400), rng, mesh.center_mass)
    sample = BoundedSample(lambda *_: pytest.fail("computed"))
    sample.extend(values, exact=True)
    assert found.grasps == len(values) > 50
    assert found.value == percentile(values, 75)
    assert found.std == percentile_std(sample, 75)
    limits = graspability_limits(found.value, settings.space)
    assert found.confidence == confidence_between(sample, 75, limits)


def test_candidates_are_doubled_until_the_cell_is_certain(spiky_box):
    settings = parameters(confidence=0.95, candidates=50)
    rng = np.random.default_rng
    budgets = [50, 100, 200, 400, 800, 1600, 3200, 6400]
    for number in range(4):
        mesh = spiky_box(number)
        found = graspability(mesh, settings, 6400, rng(0))
        tried = [graspability(mesh, settings, budget, rng(0)) for budget in budgets]
        first = next((each for each in tried if each.confidence >= 0.95), tried[-1])
        assert found == first


def test_certain_cells_are_right_as_often_as_asked_for(spiky_box):
    settings, exhaustive = (parameters(confidence=c, candidates=32) for c in (0.8, 1.0))
    right = []
    for mesh in map(spiky_box, range(7)):
        truth = graspability(mesh, exhaustive, 2**16, np.random.default_rng(99))
        low, high = graspability_limits(truth.value, settings.space)
        for seed in range(25 if truth.confidence > 0.99 else 0):
            found = graspability(mesh, settings, 4096, np.random.default_rng(seed))
            if found.confidence >= 0.8:
                right.append(low <= found.value < high)
    assert len(right) > 50
    assert np.mean(right) >= 0.8


def test_the_error_is_the_spread_of_other_grasps(spiky_box):
    settings = parameters(confidence=1.0)
    found = [graspability(spiky_box(1), settings, 512, np.random.default_rng(i)) for i in range(60)]
    spread = np.std([each.value for each in found])
    assert np.mean([each.std for each in found]) == pytest.approx(spread, rel=0.3)


def test_the_rough_estimate_is_that_of_the_first_candidates():
    settings = parameters(confidence=1.0, candidates=300)
    whole = graspability(wedge(), settings, 300, np.random.default_rng(0))
    rough = rough_graspability(wedge(), settings, np.random.default_rng(0))
    assert (rough.value, rough.grasps) == (whole.value, whole.grasps)
    assert np.isnan([rough.std, rough.confidence]).all()


def test_the_estimator_of_the_paper_is_the_percentile_of_its_grasps():
    settings = parameters()
    found = spaced_graspability(wedge(), settings, 100, np.random.default_rng(0))
    mesh = wedge()
    place = aligned(mesh, settings)
    scaled = trimesh.Trimesh(_apply(place, mesh.vertices), mesh.faces, process=False)
    grasps, _ = sample_contacts(
        RayCaster(scaled), 0.05, 100, settings.sampling, np.random.default_rng(0)
    )
    com = _apply(place, mesh.center_mass)
    values = ferrari_canny(grasps.points, grasps.normals, grasps.axes, com)
    assert found.grasps == len(values) == 100
    assert found.value == pytest.approx(np.sort(values)[75], rel=1e-12)


def test_value_of_a_ball_and_of_a_slab():
    ball = measure(trimesh.creation.icosphere(subdivisions=4))
    slab = measure(trimesh.creation.box([0.04, 0.1, 0.1]))
    assert ball.grasps > 400
    assert ball.value == pytest.approx(0.0036, abs=0.0003)
    assert slab.value == pytest.approx(0.0013, abs=0.0003)


def test_unit_does_not_matter():
    mesh = wedge()
    large = trimesh.Trimesh(mesh.vertices * 1024, mesh.faces, process=False)
    assert measure(mesh) == measure(large)


def test_place_and_pose_matter_no_more_than_chance():
    mesh = wedge()
    turned = mesh.copy()
    turned.apply_transform(trimesh.transformations.rotation_matrix(2.0, [0.2, 0.7, 0.4]))
    turned.apply_translation([3, -2, 1])
    assert measure(turned, 8000)[0] == pytest.approx(measure(mesh, 8000)[0], abs=1e-4)


def test_a_given_center_of_mass_moves_with_the_mesh():
    box = trimesh.creation.box([0.04, 0.04, 0.2])
    box.apply_transform(trimesh.transformations.rotation_matrix(1.0, [0.3, 0.6, 0.9]))
    box.apply_translation([1, 2, 3])
    assert measure(box, com=box.center_mass)[0] == pytest.approx(measure(box)[0], rel=1e-6)
    end = box.vertices[0]
    assert measure(box, com=end)[0] < 0.8 * measure(box)[0]


def test_the_robust_metric_is_lower_for_objects_as_wide_as_the_hand():
    ball = trimesh.creation.icosphere(subdivisions=3)
    plain, robust = measure(ball), measure(ball, metric="robust")
    assert robust.grasps == plain.grasps
    assert 0 < robust.value < plain.value


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
    with pytest.raises(RejectedError, match=r"no grasp \(of 512 candidates"):
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

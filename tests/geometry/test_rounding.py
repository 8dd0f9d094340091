import numpy as np
import pytest
import trimesh

import egad
from egad.evolution.growth import surface
from egad.geometry import rescale, triangulation
from egad.geometry.refinement import face_areas
from egad.geometry.repair import repair, repair_for_files
from egad.geometry.rounding import USUAL, fold_heights, is_single, rounding, to_single


def turned_box(subdivisions=3):
    box = trimesh.creation.box([60, 40, 30])
    for _ in range(subdivisions):
        box = box.subdivide()
    return box.apply_transform(trimesh.transformations.euler_matrix(0.3, 0.5, 0.7))


def estimate(mesh, **changed):
    return rounding(np.asarray(changed.get("vertices", mesh.vertices)), np.asarray(mesh.faces))


@pytest.mark.parametrize("step", [0.001, 0.002, 0.004])
def test_the_estimate_is_about_as_large_as_the_rounding(step):
    box = turned_box()
    found = estimate(box, vertices=step * np.round(box.vertices / step))
    assert step / 4 < found < 4 * step


@pytest.mark.parametrize("decimals", [4, 7, 16])
def test_less_than_the_usual_rounding_is_taken_for_it(decimals):
    box = turned_box()
    found = estimate(box, vertices=box.vertices.round(decimals))
    assert found == pytest.approx(USUAL * np.sqrt(box.area), rel=1e-4)


def test_upright_planes_do_not_hide_the_usual_rounding():
    box = trimesh.creation.box([60, 40, 30]).subdivide()
    assert estimate(box) == pytest.approx(USUAL * np.sqrt(box.area))


def test_turning_moving_and_scaling_do_not_matter():
    box = turned_box()
    box.vertices = 0.004 * np.round(box.vertices / 0.004)
    found = estimate(box)
    moved = 1e-3 * (box.vertices @ trimesh.transformations.euler_matrix(1, 2, 3)[:3, :3]) + 2
    assert estimate(box, vertices=moved) == pytest.approx(1e-3 * found, rel=1e-6)


def test_curved_surfaces_are_not_mistaken_for_rounded_ones():
    ball = trimesh.creation.icosphere(4)
    assert estimate(ball) == 0
    radius = 1 + np.random.default_rng(0).uniform(-1e-4, 1e-4, len(ball.vertices))
    assert estimate(ball, vertices=ball.vertices * radius[:, None]) == 0


def test_a_flat_bump_is_no_rounding():
    # every second vertex of a plate is raised by more than the rounding that is looked for
    plate = turned_box()
    raised = plate.vertices + np.where(np.arange(len(plate.vertices)) % 2, 0.1, 0)[:, None]
    assert estimate(plate, vertices=raised) == pytest.approx(USUAL * np.sqrt(plate.area), rel=0.01)


def test_heights_of_folds_against_planes():
    mesh = trimesh.creation.icosphere(1)
    mesh.vertices *= np.random.default_rng(0).uniform(0.8, 1.2, (len(mesh.vertices), 1))
    edges = triangulation(np.asarray(mesh.vertices), np.asarray(mesh.faces, np.int32))
    found = fold_heights(edges, face_areas(edges))
    for edge, height in zip(edges.edges, found, strict=True):
        pair = [face for face in mesh.faces if np.isin(edge, face).all()]
        larger, other = sorted(pair, key=lambda f: -trimesh.Trimesh(mesh.vertices, [f]).area)
        normal = np.cross(*np.diff(mesh.vertices[larger], axis=0))
        tip = mesh.vertices[np.setdiff1d(other, edge)[0]] - mesh.vertices[edge[0]]
        assert height == pytest.approx(abs(tip @ normal) / np.linalg.norm(normal))


def test_rims_and_faces_without_area_are_left_out():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [2, 0, 0]], float)
    edges = triangulation(vertices, np.array([[0, 1, 2], [0, 1, 3]], np.int32))
    heights = fold_heights(edges, face_areas(edges))
    assert np.isinf(heights).sum() == len(edges.edges) - 1
    assert rounding(vertices, np.array([[0, 1, 1], [2, 2, 2]])) == 0


BALL = trimesh.creation.icosphere(subdivisions=3, radius=0.0517)
ROUNDED = repair_for_files(BALL).mesh
SOME, ALL = slice(None, None, 220), slice(None)


def test_rounding_is_that_of_the_files():
    values = np.random.default_rng(0).normal(size=1000)
    rounded = to_single(values)
    assert np.array_equal(rounded, values.astype(np.float32))
    assert is_single(rounded)
    assert not is_single(values)
    assert np.abs(rounded / values - 1).max() <= 2**-24


def test_a_repaired_mesh_is_rounded_and_keeps_its_faces():
    exact, rounded = repair(BALL), repair_for_files(BALL)
    assert not is_single(exact.mesh.vertices)
    assert np.array_equal(rounded.mesh.vertices, to_single(exact.mesh.vertices))
    assert np.array_equal(rounded.mesh.faces, exact.mesh.faces)
    assert rounded._replace(mesh=None) == exact._replace(mesh=None)


def test_details_that_rounding_would_destroy_stay_as_they_are():
    far = BALL.copy().apply_translation((1e6, 0, 0))
    found = repair_for_files(far).mesh
    assert np.array_equal(found.vertices, repair(far).mesh.vertices)


def test_scaling_keeps_single_precision_and_doubles():
    for mesh in (BALL, ROUNDED):
        scaled, row = rescale(mesh, "exact", 0.05, 0.8)
        exact = np.asarray(mesh.vertices) * row["factor"]
        single = is_single(mesh.vertices)
        assert np.array_equal(scaled.vertices, to_single(exact) if single else exact)


@pytest.mark.parametrize("chosen", [SOME, pytest.param(ALL, marks=pytest.mark.slow)])
def test_released_objects_keep_their_topology(chosen):
    for each in list(egad.load("released"))[chosen]:
        exact = repair(surface(each.voxels, each.shape)).mesh
        check_rounded(each.mesh, exact)
        scaled, factor = egad.rescale(each.mesh, "egad_75mm")
        assert is_single(scaled.vertices)
        check_rounded(scaled, exact.copy().apply_scale(factor))


def check_rounded(mesh, exact):
    """Nothing but the last digits of the coordinates is different."""
    assert is_single(mesh.vertices)
    assert np.array_equal(mesh.faces, exact.faces)
    assert np.abs(mesh.vertices - exact.vertices).max() < 1e-8
    assert len(np.unique(mesh.vertices, axis=0)) == len(mesh.vertices)
    assert mesh.area_faces.min() > 0
    assert mesh.is_watertight
    assert not repair(mesh).changed  # it neither crosses itself nor has another body

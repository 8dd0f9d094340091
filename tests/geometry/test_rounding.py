import numpy as np
import pytest
import trimesh

from egad.geometry import triangulation
from egad.geometry.refinement import face_areas
from egad.geometry.rounding import USUAL, fold_heights, rounding


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

import numpy as np
import pytest
import trimesh

from egad.geometry.distance import nearest


@pytest.fixture
def rng():
    return np.random.default_rng(5)


def test_distances_are_those_to_all_triangles(rng):
    mesh = trimesh.creation.torus(0.03, 0.01, major_sections=24, minor_sections=12)
    points = rng.uniform(-0.05, 0.05, (200, 3))
    found, where = nearest(points, mesh)
    places, expected, _ = trimesh.proximity.closest_point_naive(mesh, points)
    assert found == pytest.approx(expected, abs=1e-12)
    assert where == pytest.approx(places, abs=1e-9)


def test_a_finely_meshed_side_does_not_hide_a_coarse_one():
    low = [[[0, 0, 0], [1, 0, 0], [0, 1, 0]]]
    along = np.linspace(0, 0.3, 40)
    high = [[[x, 0.3, 0.1], [x + 0.01, 0.3, 0.1], [x, 0.31, 0.1]] for x in along]
    both = np.reshape(low + high, (-1, 3))
    mesh = trimesh.Trimesh(both, np.arange(len(both)).reshape(-1, 3), process=False)
    assert nearest(np.array([[0.1, 0.3, 0.04]]), mesh)[0] == pytest.approx(0.04)


def test_triangles_without_area_are_left_out():
    mesh = trimesh.creation.box((1, 1, 1))
    faces = np.vstack([mesh.faces, [[0, 0, 1], [2, 2, 2]]])
    broken = trimesh.Trimesh(mesh.vertices, faces, process=False)
    assert nearest(np.array([[0.0, 0.0, 0.9]]), broken)[0] == pytest.approx(0.4)


def test_no_points_have_no_distances():
    assert nearest(np.empty((0, 3)), trimesh.creation.box((1, 1, 1)))[0].shape == (0,)

import numpy as np
import pytest
import trimesh

from egad.geometry.distance import largest_deviation, nearest
from egad.geometry.surface_samples import spread


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


def test_a_surface_does_not_stray_from_itself_however_it_is_meshed():
    coarse = trimesh.creation.box((0.1, 0.1, 0.1))
    fine = coarse
    for step in range(6):  # finely near one corner only
        near = np.linalg.norm(fine.triangles_center - 0.05, axis=1) < 0.02 + 0.1 * 0.5**step
        vertices, faces = trimesh.remesh.subdivide(fine.vertices, fine.faces, np.flatnonzero(near))
        fine = trimesh.Trimesh(vertices, faces, process=False)
    assert largest_deviation(coarse, fine) == pytest.approx(0, abs=1e-9)
    assert largest_deviation(fine, coarse) == pytest.approx(0, abs=1e-9)


def test_what_sticks_out_is_measured_at_its_corners_and_between_them():
    inner = trimesh.creation.icosphere(subdivisions=3, radius=1.0)
    assert largest_deviation(trimesh.creation.box((2, 2, 2)), inner) == pytest.approx(
        np.sqrt(3) - 1, abs=0.01
    )
    # a flat triangle under a tent: farthest below its top, not at a corner
    flat = trimesh.Trimesh([[-1, 0, 0], [1, 0, 0], [0, 2, 0]], [[0, 1, 2]])
    top = [0, 0.7, 1]
    tent = trimesh.Trimesh([*flat.vertices, top], [[0, 1, 3], [1, 2, 3], [2, 0, 3]])
    inside = np.random.default_rng(0).dirichlet((1, 1, 1), 5000) @ flat.vertices
    _, away, _ = trimesh.proximity.closest_point_naive(tent, inside)
    assert largest_deviation(flat, tent) == pytest.approx(away.max(), abs=0.02)


@pytest.mark.parametrize("seed", range(3))
def test_no_point_that_is_furthest_is_left_out(seed):
    """As if all points were looked at."""
    rng = np.random.default_rng(seed)
    inner = trimesh.creation.icosphere(subdivisions=2)
    outer = inner.copy()
    outer.vertices *= 1 + 0.2 * rng.random((len(outer.vertices), 1))
    outer.vertices *= [1, 1, 8]  # thin triangles
    inner.vertices *= [1, 1, 8]
    step = 0.02 * np.ptp(inner.vertices, axis=0).max()
    points = np.concatenate([outer.vertices, spread(outer, step).points])
    assert largest_deviation(outer, inner) == nearest(points, inner)[0].max()

import numpy as np
import pytest
import trimesh

from egad.shapes.deviation import _furthest, largest_deviation
from egad.shapes.distances import nearest


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


@pytest.mark.parametrize("size", [0.02, 0.2, 1.0, 10.0])
def test_the_furthest_point_is_that_of_all_points(size):
    mesh = trimesh.creation.torus(1.0, 0.4, 24, 12)
    for seed in range(10):
        points = np.random.default_rng(seed).normal(size=(300, 3))
        assert _furthest(points, mesh, size) == nearest(points, mesh)[0].max()

import numpy as np
import pytest
import trimesh

from egad.geometry.distance import largest_deviation, nearest
from egad.geometry.surface_samples import spread


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

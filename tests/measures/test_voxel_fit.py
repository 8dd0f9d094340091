import numpy as np
import pytest
import trimesh

import egad
from egad.geometry import Smoothing, voxel_surface
from egad.measures.voxel_fit import FitTarget, Grid, aligned, compare, deviation, fit

UPRIGHT = np.eye(3)


@pytest.fixture(scope="module", params=["I04_1", "Y14_0"])
def known(request):
    """An object, and the grid that its voxels are on."""
    voxels = np.asarray(egad.load("released")[request.param].voxels)
    _, surface = voxel_surface(voxels, Smoothing())
    target = FitTarget(surface)
    low, high = surface.bounds - 1
    pitch = 25 / (high - low).max()
    grid = Grid(-(low + high) / 2 * pitch, UPRIGHT, pitch, voxels.shape)
    return target, grid, voxels


def test_the_voxels_of_a_surface_have_no_deviation(known):
    target, grid, voxels = known
    exact = compare(target, grid, voxels)
    assert exact.deviation < 1e-3
    assert exact.offsets == pytest.approx(0, abs=0.5)
    assert fit(target, grid, 0).deviation > 0.01  # voxels with their centers inside are others


def test_rounds_recover_the_voxels(known):
    target, grid, voxels = known
    first, last = fit(target, grid, 0), fit(target, grid, 8)
    missed = [np.count_nonzero(each.voxels != voxels) for each in (first, last)]
    assert missed[1] < missed[0] / 2
    assert missed[1] <= max(1, 0.002 * voxels.sum())


def test_a_grid_beside_the_right_one_is_aligned(known):
    target, grid, voxels = known
    for turn in (False, True):
        angle = 0.01 if turn else 0.0
        frame = trimesh.transformations.rotation_matrix(angle, [1, 2, 3])[:3, :3]
        off = Grid(grid.origin @ frame + [0.05, -0.04, 0.03], frame, grid.pitch * 1.002, grid.shape)
        better = aligned(target, compare(target, off, voxels), turn)
        assert better.pitch == pytest.approx(grid.pitch, rel=5e-4)
        assert better.frame == pytest.approx(UPRIGHT, abs=2e-3)
        shift = (better.origin - grid.origin) / grid.pitch
        assert shift == pytest.approx(np.round(shift), abs=0.02)


def test_few_vertices_tell_about_the_same_deviation(known):
    target, grid, _ = known
    assert deviation(target, grid, 10**6) == pytest.approx(fit(target, grid, 0).deviation)
    assert deviation(target, grid, 1000) == pytest.approx(fit(target, grid, 0).deviation, rel=0.2)


def test_a_grid_that_misses_the_mesh_fits_nothing():
    plate = FitTarget(trimesh.creation.box([1, 1, 0.001]))
    grid = Grid(np.full(3, 100.0), UPRIGHT, 1.0, (3, 3, 3))
    assert fit(plate, grid, 2) is None
    assert deviation(plate, grid, 100) == np.inf


def test_the_grid_surrounds_the_mesh():
    target = FitTarget(trimesh.creation.icosphere(3, 7.0).apply_translation([40, 2, 1]))
    frame = trimesh.transformations.rotation_matrix(0.4, [1, 1, 0])[:3, :3]
    grid = Grid.around(target, frame, 1.1, np.zeros(3))
    inside = target.inside(grid.centers()).reshape(grid.shape)
    assert inside.any()
    assert not any(
        side.any() for axis in range(3) for side in np.moveaxis(inside, axis, 0)[[0, -1]]
    )

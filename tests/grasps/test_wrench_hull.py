import numpy as np
import pytest

from egad.grasps import wrench_hull as hull
from egad.grasps.wrench_hull import depths, slow_depth


def assert_equal_to_qhull(points):
    expected = np.array([slow_depth(each) for each in points])
    np.testing.assert_allclose(depths(points), expected, atol=1e-12)
    return expected


@pytest.mark.parametrize("count", [7, 8, 13, 20])
def test_equals_qhull_on_random_points(count):
    points = np.random.default_rng(count).normal(size=(200, count, 6))
    assert_equal_to_qhull(points)


def test_equals_qhull_where_many_points_are_coplanar():
    points = np.random.default_rng(0).integers(-2, 3, size=(200, 25, 6)).astype(float)
    assert (assert_equal_to_qhull(points) > 0).mean() > 0.9


def test_equals_qhull_on_thin_hulls():
    points = np.random.default_rng(2).normal(size=(200, 20, 6)) * [1, 1, 1, 100, 100, 1e-5]
    assert (assert_equal_to_qhull(points) > 0).any()


def test_known_solids():
    cross = np.concatenate([np.eye(6), -np.eye(6)])
    assert depths(cross[None]) == pytest.approx(1 / np.sqrt(6), abs=1e-14)
    assert depths(3 * cross[None] + 0.1 * np.eye(6)[0]) == pytest.approx(2.9 / np.sqrt(6))


def test_origin_outside_or_on_the_boundary_gives_zero():
    points = np.random.default_rng(3).normal(size=(20, 20, 6))
    moved = points - points.max(axis=1, keepdims=True) * [1, 0, 0, 0, 0, 0]
    assert (depths(moved) == 0).all()
    assert (depths(moved - [1, 0, 0, 0, 0, 0]) == 0).all()


@pytest.mark.parametrize("rank", range(6))
def test_flat_hulls_give_zero(rank):
    rng = np.random.default_rng(rank)
    points = rng.normal(size=(20, 20, rank)) @ rng.normal(size=(20, rank, 6))
    assert (depths(points) == 0).all()


def test_not_a_number_gives_zero():
    assert depths(np.full((1, 20, 6), np.nan)) == 0


def test_hulls_too_large_for_the_workspace_fall_back_to_qhull():
    points = np.random.default_rng(4).normal(size=(3, 60, 6))
    points /= np.linalg.norm(points, axis=2, keepdims=True)
    assert np.isnan(hull._depths(points, 0.0)).any()
    assert_equal_to_qhull(points)

"""Where fingers can touch a surface, and how much of that lies in convex parts."""

import numpy as np
import pytest
import trimesh

from egad._util.arrays import dot_products
from egad.geometry.hulls import hull_of
from egad.geometry.touchable import (
    Touchable,
    buried_share,
    deeper_points,
    depths,
    facing_depths,
    touchable_points,
)


def plates():
    """Two cubes of 30 mm, 8 mm apart."""
    cubes = [trimesh.creation.box((0.03, 0.03, 0.03)) for _ in range(2)]
    cubes[1].apply_translation([0.038, 0, 0])
    return trimesh.util.concatenate(cubes)


def test_a_gap_that_is_narrower_than_a_finger_cannot_be_touched():
    points, normals = touchable_points(plates(), "test")
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1)
    faces_the_gap = (normals[:, 0] * (points[:, 0] - 0.019)) < 0
    assert not faces_the_gap.any()
    assert len(points) == pytest.approx(16000 * 10 / 12, abs=3)  # the other sides of the cubes


def test_points_are_the_same_each_time_and_others_for_another_purpose():
    first, again, other = (touchable_points(plates(), name).points for name in ("a", "a", "b"))
    np.testing.assert_array_equal(first, again)
    assert not np.isin(first, other).all(axis=1).any()


def test_the_share_that_a_bigger_part_buries():
    cube = trimesh.creation.box((0.02, 0.02, 0.02))
    assert buried_share(cube, [cube], 1e-6) == 0
    taller = trimesh.creation.box((0.04, 0.04, 0.03))
    taller.apply_translation([0, 0, 0.005])  # its bottom is that of the cube
    assert buried_share(cube, [taller], 0.0005) == pytest.approx((5 - 0.1) / 6, abs=0.002)
    assert buried_share(cube, [taller], 0.011) == 0


def test_only_planes_that_face_the_finger_count():
    top_and_side = np.array([[0.0, 0.0, 1.0, -0.010], [1.0, 0.0, 0.0, -0.001]])
    upwards = np.array([[0.0, 0.0, 1.0]] * 2)
    points = Touchable(np.array([[0.0, 0.0, 0.009], [0.0005, 0.0, 0.009]]), upwards)
    np.testing.assert_allclose(depths(points.points, top_and_side), [0.001, 0.0005])
    found = facing_depths(points, top_and_side)
    np.testing.assert_allclose(found, [[0.001, np.inf], [0.001, np.inf]])


def test_deeper_points_are_those_whose_depths_are_larger():
    rng = np.random.default_rng(2)
    planes = hull_of(rng.normal(size=(40, 3))).planes
    points, normals = rng.normal(size=(2, 2000, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    all_planes = depths(points, planes) > 0.2
    facing = facing_depths(Touchable(points, normals), planes).min(axis=1) > 0.4
    found = deeper_points(points, normals, planes, 0.2, 0.4)
    np.testing.assert_array_equal(found, all_planes & facing)
    assert 0 < found.sum() < all_planes.sum()


def test_depths_are_those_of_matrix_products():
    rng = np.random.default_rng(0)
    points, planes = rng.normal(size=(200, 3)), rng.normal(size=(30, 4))
    slow = -(points @ planes[:, :3].T + planes[:, 3]).max(axis=1)
    np.testing.assert_allclose(depths(points, planes), slow, atol=1e-14)
    products = dot_products(points, planes[:, :3])
    np.testing.assert_allclose(products, points @ planes[:, :3].T, atol=1e-14)

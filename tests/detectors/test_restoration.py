"""Restored images are those of an ideal camera, as nearly as noise allows."""

import numpy as np
import pytest
import trimesh

from egad.detectors import (
    DepthCamera,
    ImageNoise,
    Intrinsics,
    View,
    add_sensor_noise,
    camera_above,
    fill_missing,
    restore,
)
from egad.detectors.camera import object_mask
from egad.detectors.restoration import noise_of

CAMERA = Intrinsics.spanning(320, 240, 40.0)
NAN = np.nan


def ideal(mesh: trimesh.Trimesh, x: float = 0.0) -> View:
    matrix = trimesh.transformations.translation_matrix((x, 0, 0))
    return DepthCamera(mesh).render(matrix, CAMERA, camera_above(0.6))


def noisy(view: View, sigma: float = 0.1, seed: int = 0) -> View:
    noise = ImageNoise(disparity=sigma, holes=True)
    return add_sensor_noise(view, noise, np.random.default_rng(seed))


def block(width: float, depth: float, height: float) -> trimesh.Trimesh:
    low, high = (-width / 2, -depth / 2, 0), (width / 2, depth / 2, height)
    return trimesh.creation.box(bounds=[low, high])


def test_a_gap_is_filled_with_what_lies_behind_it() -> None:
    depth = np.array([[1, NAN, NAN, 3, NAN], [NAN, 5, NAN, 4, 4], [NAN] * 5], dtype=np.float32)
    expected = [[1, 3, 3, 3, 3], [5, 5, 5, 4, 4], [5, 5, 5, 4, 4]]
    found = fill_missing(depth)
    np.testing.assert_array_equal(found, expected)
    assert found.dtype == np.float32


def test_the_noise_is_known_from_the_table() -> None:
    rng = np.random.default_rng(0)
    heights = rng.normal(0, 0.002, (200, 200))
    heights[50:150, 50:150] += 0.06
    assert noise_of(heights) == pytest.approx(0.002, rel=0.05)
    assert noise_of(np.full((5, 5), 0.01)) == 0


def test_an_ideal_image_stays_as_it_is() -> None:
    view = ideal(block(0.05, 0.05, 0.05))
    assert restore(view).depth is view.depth


def test_the_shadow_of_a_box_becomes_table() -> None:
    view = ideal(block(0.05, 0.05, 0.06))
    holes = add_sensor_noise(view, ImageNoise(holes=True), np.random.default_rng(0))
    assert np.isnan(holes.depth).sum() > 100
    np.testing.assert_allclose(restore(holes).depth, view.depth, atol=1e-6)


@pytest.mark.parametrize("sigma", [0.05, 0.1, 0.2])
def test_table_and_box_are_told_apart(sigma: float) -> None:
    view = ideal(block(0.05, 0.08, 0.04), x=0.02)
    for seed in range(5):
        found = restore(noisy(view, sigma, seed))
        assert np.isfinite(found.depth).all()
        stands, known = object_mask(view), found.heights() > 0.003
        assert (stands != known).sum() < 0.05 * stands.sum()
        assert not known[:60].any()
        assert found.heights()[known].mean() == pytest.approx(0.04, abs=0.002)


@pytest.mark.parametrize("angle", [0.0, 30.0, 50.0])
def test_slopes_are_those_of_the_surface(angle: float) -> None:
    """Lines fitted to the sides of a roof rise by the tangent of its angle.

    A side has 27 windows of pixels that err together: noise tilts the line with a
    standard deviation of about 2.5 degrees.
    """
    rise = 0.03 * np.tan(np.radians(angle))
    profile = [(-0.03, 0.02), (0, 0.02 + rise), (0.03, 0.02)]
    corners = [(x, y, z) for y in (-0.06, 0.06) for x, z in [*profile, (-0.03, 0), (0.03, 0)]]
    view = ideal(trimesh.convex.convex_hull(np.array(corners)))
    slopes = []
    for seed in range(5):
        points = restore(noisy(view, seed=seed)).points().reshape(-1, 3)
        for side in (-1, 1):
            near = (np.abs(points[:, 0] * side - 0.015) < 0.011) & (np.abs(points[:, 1]) < 0.05)
            slopes.append(-side * np.polyfit(points[near, 0], points[near, 2], 1)[0])
    found = np.degrees(np.arctan(slopes))
    np.testing.assert_allclose(found, angle, atol=6)
    assert found.mean() == pytest.approx(angle, abs=2)


def test_without_any_depth_nothing_is_restored() -> None:
    blind = View(np.full((240, 320), np.nan, dtype=np.float32), CAMERA, camera_above(0.6))
    assert np.isnan(restore(blind).depth).all()

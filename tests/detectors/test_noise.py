"""Noise is as large as it says, and where a real camera has it."""

import numpy as np
import pytest
import trimesh

from egad.detectors import (
    DepthCamera,
    ImageNoise,
    Intrinsics,
    View,
    add_noise,
    add_sensor_noise,
    camera_above,
)
from egad.detectors.noise import BASELINE, add_gamma_noise, grazing, stereo_shadow

NOISE = ImageNoise(disparity=0.1)
SMALL = Intrinsics.spanning(101, 101, 40.0)


def shifted(x: float, y: float, z: float) -> np.ndarray:
    return trimesh.transformations.translation_matrix((x, y, z))


def test_noise_grows_with_the_square_of_the_depth() -> None:
    """As baseline * focal length / depth errs by a tenth of a pixel."""
    box = DepthCamera(trimesh.creation.box((0.1, 0.1, 0.1)))
    camera = Intrinsics.spanning(200, 200, 30.0)
    for height in (0.6, 1.2):
        view = box.render(shifted(5, 5, 0), camera, camera_above(height))
        noise = add_sensor_noise(view, NOISE, np.random.default_rng(0)).depth - view.depth
        expected = height**2 * 0.1 / (BASELINE * camera.focal)
        assert noise.std() == pytest.approx(expected, rel=0.06)
        assert abs(noise.mean()) < expected / 8


def test_noise_is_alike_within_the_windows_that_are_matched() -> None:
    """Two windows of 7 pixels, shifted by k, share 1 - k / 7 of their pixels."""
    view = DepthCamera(trimesh.creation.box()).render(
        shifted(5, 5, 0), Intrinsics.spanning(640, 480, 75.0), camera_above(0.6)
    )
    depth = add_sensor_noise(view, NOISE, np.random.default_rng(0)).depth.astype(np.float64)
    error = (1 / depth - 1 / view.depth)[:400, :600]
    error /= error.std()
    for shift in range(10):
        expected = max(1 - shift / 7, 0)
        assert (error[:, : 600 - shift] * error[:, shift:]).mean() == pytest.approx(
            expected, abs=0.05
        )
        assert (error[: 400 - shift] * error[shift:]).mean() == pytest.approx(expected, abs=0.05)


def test_noise_leaves_the_image_alone_that_it_is_added_to() -> None:
    view = DepthCamera(trimesh.creation.box()).render(shifted(5, 5, 0), SMALL, camera_above(0.6))
    before = view.depth.copy()
    first, second = (
        add_sensor_noise(view, NOISE, np.random.default_rng(3)).depth for _ in range(2)
    )
    np.testing.assert_array_equal(view.depth, before)
    np.testing.assert_array_equal(first, second)


def seen(**noise):
    """A box of 100 x 100 x 60 mm in the middle, straight from above, with such noise."""
    box = DepthCamera(trimesh.creation.box((0.1, 0.1, 0.06)))
    camera = Intrinsics(300, 300, 417.0, (149.5, 149.5))
    view = box.render(shifted(0, 0, 0.03), camera, camera_above(0.6))
    return view, add_sensor_noise(view, ImageNoise(**noise), np.random.default_rng(0))


def test_shadows_lie_beside_edges_as_wide_as_the_disparities_differ() -> None:
    """On the left, as the second imager is to the right; baseline * focal * (1/near - 1/far)."""
    view, found = seen(holes=True)
    near, far = 0.54, 0.6
    width = BASELINE * 417 * (1 / near - 1 / far)
    rows, columns = np.nonzero(np.isnan(found.depth))
    left = 149.5 - 0.05 / near * 417
    assert np.ptp(columns) + 1 == pytest.approx(width, abs=1)
    assert columns.max() == np.floor(left)
    assert np.ptp(rows) + 1 == pytest.approx(0.1 / near * 417, abs=1)
    assert not stereo_shadow(seen()[0])[:, 200:].any()
    there = np.isfinite(found.depth)
    np.testing.assert_array_equal(found.depth[there], view.depth[there])


def test_a_sphere_has_no_depth_where_the_line_of_sight_grazes_it() -> None:
    """That passes its center at d meets it at an angle whose sine is d / radius."""
    radius, height = 0.1, 0.6
    camera = Intrinsics.spanning(401, 401, 25.0)
    sphere = DepthCamera(trimesh.creation.icosphere(6, radius))
    view = sphere.render(shifted(0, 0, radius), camera, camera_above(height))
    rays = camera.rays()
    sine = (height - radius) * np.hypot(rays[..., 0], rays[..., 1])
    sine /= radius * np.linalg.norm(rays, axis=-1)
    angle = np.degrees(np.arcsin(np.minimum(sine, 1)))
    lost = grazing(view)
    assert lost[(angle > 82) & (angle < 87)].all()
    assert not lost[angle < 78].any()
    assert not lost[sine > 1.02].any()


def test_so_many_pixels_are_lost_in_spots() -> None:
    _, found = seen(missing=0.05)
    lost = np.isnan(found.depth)
    assert lost.mean() == pytest.approx(0.05, rel=0.01)
    beside = lost[:, 1:] & lost[:, :-1]
    assert beside.mean() > 5 * 0.05**2


def test_gamma_noise_scales_the_image_and_blurs_the_rest() -> None:
    """Over many images: a common factor of standard deviation 0.032, and 5 mm every 4 pixels."""
    view = View(np.full((120, 160), 0.6, np.float32), Intrinsics.spanning(160, 120, 60), np.eye(4))
    rng = np.random.default_rng(0)
    found = np.stack([add_gamma_noise(view, rng).depth for _ in range(400)]).astype(float)
    means = found.mean(axis=(1, 2))
    assert means.mean() == pytest.approx(0.6, abs=0.003)
    assert means.std() == pytest.approx(0.6 / np.sqrt(1000), rel=0.1)
    grid = found - means[:, None, None]
    # Bilinear interpolation keeps the variance at the nodes and lowers it between them.
    assert 0.003 < grid.std() < 0.005
    along = (grid[:, :, :-1] * grid[:, :, 1:]).mean() / grid.var()
    apart = (grid[:, :, :-12] * grid[:, :, 12:]).mean() / grid.var()
    assert along > 0.8
    assert abs(apart) < 0.05


def test_the_noise_of_giga_has_its_moments() -> None:
    """One factor for an image, and in half of the images 5 mm at every fourth pixel."""
    view = View(np.full((120, 160), 0.6, np.float32), Intrinsics.spanning(160, 120, 60), np.eye(4))
    rng = np.random.default_rng(0)
    found = np.stack([add_noise("dex", view, rng).depth for _ in range(600)]).astype(float)
    rough = found.std(axis=(1, 2)) > 1e-5
    # 300 of 600 with a standard deviation of 12.2
    assert abs(rough.sum() - 300) < 45
    plain = found[~rough][:, 0, 0] / 0.6
    np.testing.assert_array_equal(found[~rough], found[~rough][:, :1, :1] * np.ones((1, 120, 160)))
    assert plain.mean() == pytest.approx(1, abs=0.008)
    assert plain.std() == pytest.approx(np.sqrt(1000) * 0.001, rel=0.15)
    assert abs(((plain - plain.mean()) ** 3).mean() / plain.std() ** 3 - 2 / np.sqrt(1000)) < 0.5
    corners = found[rough][:, [0, 0, -1, -1], [0, -1, 0, -1]]
    apart = corners - found[rough].mean(axis=(1, 2))[:, None]
    assert apart.std() == pytest.approx(0.005, rel=0.08)  # nodes of the grid

"""Depth images are exact, metric, and where the camera is."""

import numpy as np
import pytest
import trimesh

from egad.detectors import DepthCamera, Intrinsics, camera_above
from egad.detectors.camera import object_mask

SMALL = Intrinsics.spanning(101, 101, 40.0)


def shifted(x: float, y: float, z: float) -> np.ndarray:
    return trimesh.transformations.translation_matrix((x, y, z))


def tilted_camera() -> np.ndarray:
    """40 cm in front of the origin and 30 above, looking at it."""
    pose = np.eye(4)
    pose[:3, 2] = np.array([0, 0.4, -0.3]) / 0.5
    pose[:3, 0] = [1, 0, 0]
    pose[:3, 1] = np.cross(pose[:3, 2], pose[:3, 0])
    pose[:3, 3] = [0, -0.4, 0.3]
    return pose


def test_intrinsics_span_the_field_of_view() -> None:
    size, degrees = 300, 40.0
    camera = Intrinsics.spanning(size, size, degrees)
    rays = camera.rays()
    half = np.tan(np.radians(degrees / 2))
    pixel = 2 * half / size
    np.testing.assert_allclose(rays[0, 0], [-half + pixel / 2, -half + pixel / 2, 1])
    np.testing.assert_allclose(rays[-1, -1], [half - pixel / 2, half - pixel / 2, 1])


def test_depth_is_measured_along_the_optical_axis() -> None:
    """A plate parallel to the image has one depth, also towards the corners."""
    plate = trimesh.creation.box((2.0, 2.0, 0.1))
    view = DepthCamera(plate).render(shifted(0, 0, 0.05), SMALL, camera_above(0.6))
    np.testing.assert_allclose(view.depth, 0.5, rtol=1e-6)


@pytest.mark.parametrize("pose", [camera_above(0.6), tilted_camera()])
def test_points_lie_on_the_ball_or_on_the_table(pose: np.ndarray) -> None:
    center, radius = np.array([0.03, -0.02, 0.04]), 0.04
    ball = trimesh.creation.icosphere(5, radius)
    view = DepthCamera(ball).render(shifted(*center), SMALL, pose)
    points = view.points().reshape(-1, 3)
    from_ball = np.abs(np.linalg.norm(points - center, axis=1) - radius)
    on_ball, on_table = from_ball < 1e-4, np.abs(points[:, 2]) < 1e-6
    assert (on_ball | on_table).all()
    # The cone of rays that touch the ball fills this part of the image.
    distance = np.linalg.norm(center - pose[:3, 3])
    seen = np.pi * radius**2 / (distance**2 - radius**2) * SMALL.focal**2
    assert on_ball.sum() == pytest.approx(seen, rel=0.1)


def test_image_axes_are_those_of_the_camera() -> None:
    """Right in the image is +x of the world, up is +y."""
    box = DepthCamera(trimesh.creation.box((0.04, 0.02, 0.06)))
    view = box.render(shifted(0.1, 0.05, 0.03), SMALL, camera_above(0.6))
    rows, columns = np.nonzero(view.depth < 0.55)
    assert columns.min() > 50
    assert rows.max() < 50
    top = view.points()[rows, columns]
    np.testing.assert_allclose(top.mean(axis=0), [0.1, 0.05, 0.06], atol=0.002)
    np.testing.assert_allclose(np.ptp(top, axis=0)[:2], [0.04, 0.02], atol=0.006)


def test_partly_beside_and_behind_the_camera() -> None:
    """An object as wide as the room, that the camera stands in: only the lower side is seen."""
    floor = trimesh.creation.box((4.0, 4.0, 0.2))
    view = DepthCamera(floor).render(shifted(0, 0, 0.1), SMALL, camera_above(0.6))
    np.testing.assert_allclose(view.depth, 0.4, rtol=1e-6)
    around = DepthCamera(trimesh.creation.box((4.0, 4.0, 4.0)))
    view = around.render(shifted(0, 0, 2.1), SMALL, camera_above(0.6))
    np.testing.assert_allclose(view.depth, 0.5, rtol=1e-6)


def test_rays_above_the_horizon_meet_nothing() -> None:
    level = np.eye(4)
    level[:3, :3] = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])  # forward is +y
    level[2, 3] = 0.3
    view = DepthCamera(trimesh.creation.box((0.1, 0.1, 0.1))).render(
        shifted(0, 1.0, 0.05), SMALL, level
    )
    assert np.isnan(view.depth[:50]).all()
    assert np.isfinite(view.depth[51:]).all()
    assert np.nanmin(view.depth) == pytest.approx(0.3 / np.tan(np.radians(20)), rel=0.02)


def test_what_is_in_the_image() -> None:
    camera = Intrinsics.spanning(640, 480, 75.0)
    half = np.tan(np.radians(37.5))
    right, down = np.array([half, 0, 1]), np.array([0, half * 480 / 640, 1])
    for edge in (right, -right * [1, 1, -1], down, -down * [1, 1, -1]):
        assert camera.sees(np.array([0.999 * edge * [1, 1, 0] + [0, 0, 1]]))
        assert not camera.sees(np.array([[0, 0, 1.0], 1.001 * edge * [1, 1, 0] + [0, 0, 1]]))
    assert not camera.sees(np.array([[0, 0, 1.0], [0, 0, -1.0]]))


def test_the_mask_is_the_silhouette() -> None:
    """Its pixels are those whose rays meet the ball, whatever the camera's tilt."""
    center, radius = np.array([0.03, -0.02, 0.04]), 0.04
    for pose in (camera_above(0.6), tilted_camera()):
        view = DepthCamera(trimesh.creation.icosphere(5, radius)).render(
            shifted(*center), SMALL, pose
        )
        rays = SMALL.rays() @ pose[:3, :3].T
        away = np.cross(rays, center - pose[:3, 3])
        distance = np.linalg.norm(away, axis=-1) / np.linalg.norm(rays, axis=-1)
        mask = object_mask(view)
        assert mask[distance < radius - 1e-4].all()
        assert not mask[distance > radius + 1e-4].any()


def test_a_window_has_the_rays_of_its_pixels() -> None:
    window = (slice(3, 7), slice(90, None))
    np.testing.assert_array_equal(SMALL.rays(window), SMALL.rays()[window])


def test_pixels_are_where_rays_go_through() -> None:
    points = SMALL.rays().reshape(-1, 3) * 0.7
    u, v = np.meshgrid(np.arange(101), np.arange(101))
    expected = np.column_stack([u.ravel(), v.ravel()])
    np.testing.assert_allclose(SMALL.pixels(points), expected, atol=1e-9)

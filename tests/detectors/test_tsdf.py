"""Fused depth images have the distances and the surface of what the cameras see."""

import numpy as np
import pytest
import trimesh
from skimage.measure import marching_cubes

from egad.detectors import DepthCamera, Intrinsics, Tsdf, View, camera_above, cameras_around, fuse
from egad.detectors.tsdf import TRUNCATION

CAMERA = Intrinsics(320, 240, 208.0, (159.5, 119.5))
RADIUS, CENTER = 0.04, np.array([0.01, -0.02, 0.05])
CORNER, SIDE = np.array([-0.1, -0.1, -0.05]), 0.2


@pytest.fixture(scope="module")
def ball_views():
    eye = DepthCamera(trimesh.creation.icosphere(4, RADIUS))
    matrix = np.eye(4)
    matrix[:3, 3] = CENTER
    poses = cameras_around(np.zeros(3), 6, 0.5, np.radians(30))
    return [eye.render(matrix, CAMERA, pose) for pose in poses]


def slow_fuse(views, resolution):
    """Voxel by voxel, as the definition says."""
    voxel = SIDE / resolution
    band = TRUNCATION * voxel
    distances, weights = np.zeros((resolution,) * 3), np.zeros((resolution,) * 3)
    for index in np.ndindex(distances.shape):
        center = CORNER + (np.array(index) + 0.5) * voxel
        found = []
        for view in views:
            x, y, z = np.linalg.inv(view.pose)[:3] @ np.append(center, 1)
            u, v = np.round(np.array([x, y]) / z * CAMERA.focal + CAMERA.center).astype(int)
            if 0 <= u < CAMERA.width and 0 <= v < CAMERA.height:
                ray = np.append((np.array([u, v]) - CAMERA.center) / CAMERA.focal, 1)
                found.append((view.depth[v, u] - z) * np.linalg.norm(ray))
        kept = [min(1, each / band) for each in found if each > -band]
        weights[index] = len(kept)
        distances[index] = np.mean(kept) if kept else 0
    return distances, weights


def test_fusion_equals_its_definition(ball_views):
    fused = fuse(ball_views, CORNER, SIDE, 12)
    distances, weights = slow_fuse(ball_views, 12)
    np.testing.assert_array_equal(fused.weights, weights)
    np.testing.assert_allclose(fused.distances, distances, atol=1e-5)


def test_the_surface_of_a_ball_is_found(ball_views):
    fused = fuse(ball_views, CORNER, SIDE, 80)
    points, normals = fused.surface()
    outward = points - CENTER
    distance = np.linalg.norm(outward, axis=1)
    seen = (points[:, 2] > CENTER[2]) & (distance < 1.5 * RADIUS)
    assert seen.sum() > 500
    np.testing.assert_allclose(distance[seen], RADIUS, atol=1.5 * fused.voxel)
    facing = points[:, 2] > CENTER[2] + RADIUS / 2  # every camera sees it
    cosines = (outward * normals).sum(axis=1) / distance
    assert (cosines[facing] > np.cos(np.radians(30))).mean() > 0.99


def test_one_camera_measures_along_its_axis():
    """Straight below it, projected distances are true ones."""
    pose = camera_above(0.5)
    view = View(np.full((240, 320), 0.5, np.float32), CAMERA, pose)
    fused = fuse([view], CORNER, SIDE, 40)
    heights = CORNER[2] + (np.arange(40) + 0.5) * fused.voxel
    expected = np.clip(heights / fused.truncation, -1, 1)
    known = heights > -fused.truncation
    np.testing.assert_allclose(fused.distances[20, 20, known], expected[known], atol=0.02)
    assert (fused.weights[20, 20] == known).all()


def test_missing_depth_is_not_seen():
    view = View(np.full((240, 320), np.nan, np.float32), CAMERA, camera_above(0.5))
    fused = fuse([view], CORNER, SIDE, 10)
    assert not fused.weights.any()
    assert fused.surface()[0].shape == (0, 3)


def test_free_space_has_no_surface():
    view = View(np.full((240, 320), 5.0, np.float32), CAMERA, camera_above(0.5))
    assert len(fuse([view], CORNER, SIDE, 10).surface()[0]) == 0


def test_all_normals_have_length_1():
    """Where the gradients of two voxels cancel out, marching cubes gives a normal of length 0."""
    signs = np.random.default_rng(0).choice(np.array([-1, 1], np.float32), size=(8, 8, 8))
    _, _, normals, _ = marching_cubes(signs, 0.0)
    directed = normals.any(axis=1)
    assert 0 < directed.sum() < len(directed)
    points, normals = Tsdf(signs, np.ones_like(signs), CORNER, 0.01, 0.04).surface()
    assert len(points) == directed.sum()
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1, atol=1e-5)

"""Hulls and joining them: exact volumes, bounds, and the order in which pairs are taken."""

import numpy as np
import pytest
import trimesh
from scipy.spatial import ConvexHull

from egad.geometry.hulls import (
    fewer_vertices,
    hull_mesh,
    hull_of,
    least_volume,
    lower_planes,
    merge_hulls,
)
from egad.geometry.manifold import is_solid, to_solid


def always(_):
    return True


def block(low, high):
    return hull_of(trimesh.creation.box(bounds=[low, high]).vertices)


@pytest.mark.parametrize("seed", range(5))
def test_a_hull_has_the_volume_and_surface_of_its_points(seed):
    points = np.random.default_rng(seed).normal(size=(300, 3))
    hull = hull_of(points)
    assert hull.volume == pytest.approx(ConvexHull(points).volume)
    assert least_volume(points) <= hull.volume * (1 + 1e-9)
    mesh = hull_mesh(hull)
    assert mesh.is_volume
    assert mesh.volume == pytest.approx(hull.volume, rel=1e-9)


def test_a_hull_that_manifold3d_gets_wrong_is_still_whole(monkeypatch):
    points = np.random.default_rng(0).normal(size=(60, 3))
    hull = hull_of(points)
    monkeypatch.setattr("egad.geometry.hulls.EQUAL", -1.0)  # nothing is equal
    mesh = hull_mesh(hull)
    assert mesh.is_volume
    assert mesh.volume == pytest.approx(hull.volume, rel=1e-9)


@pytest.mark.parametrize("seed", range(6))
def test_a_hull_of_points_that_nearly_coincide_bounds_a_solid(seed):
    rng = np.random.default_rng(seed)
    points = rng.random((40, 3)) * [0.02, 0.007, 0.002]
    points[:30, 2] = 0
    twins = points[:30] + rng.normal(size=(30, 3)) * 10.0 ** -rng.integers(9, 17)
    hull = hull_of(np.concatenate([points, twins]))
    mesh = hull_mesh(hull)
    solid = to_solid(mesh.vertices, mesh.faces)
    assert is_solid(solid)
    assert solid.volume() == pytest.approx(hull.volume, rel=1e-6)


def test_points_in_a_plane_have_no_volume():
    flat = np.random.default_rng(0).normal(size=(10, 3)) * [1, 1, 0]
    assert hull_of(flat).volume == 0
    assert least_volume(flat) == 0


def test_blocks_in_a_row_become_one_and_a_step_stays():
    row = [block([k, 0, 0], [k + 1, 1, 1]) for k in range(4)]
    step = block([0, 0, 1], [1, 1, 4])
    hulls = merge_hulls([*row, step], 7.0 + 1e-9, always)
    assert sorted(hull.volume for hull in hulls) == pytest.approx([3, 4])


def test_hulls_that_would_not_fit_are_not_joined():
    row = [block([k, 0, 0], [k + 1, 1, 1]) for k in range(4)]

    def is_short(hull):
        return np.ptp(hull.points[:, 0]) < 2.5

    assert sorted(h.volume for h in merge_hulls(row, 9.0, is_short)) == pytest.approx([2, 2])


@pytest.mark.parametrize("more", [0.02, 0.05, 0.1])
def test_the_cheapest_pairs_are_joined_as_a_slow_search_does(more):
    rng = np.random.default_rng(2)
    hulls = [hull_of(rng.uniform(0, 0.6, 3) + rng.uniform(0, 0.4, (12, 3))) for _ in range(12)]
    allowed = sum(hull.volume for hull in hulls) + more
    found, slow = merge_hulls(hulls, allowed, always), slowly(hulls, allowed)
    assert 1 < len(found) < 12
    assert sorted(h.volume for h in found) == pytest.approx(sorted(h.volume for h in slow))


def slowly(hulls, allowed):
    left = list(hulls)
    while True:
        numbers = range(len(left))
        pairs = [(a, b) for a in numbers for b in range(a) if boxes_touch(left[a], left[b])]
        joined = [hull_of(np.concatenate([left[a].points, left[b].points])) for a, b in pairs]
        costs = [
            hull.volume - left[a].volume - left[b].volume
            for hull, (a, b) in zip(joined, pairs, strict=True)
        ]
        if not costs or sum(hull.volume for hull in left) + min(costs) > allowed:
            return left
        best = int(np.argmin(costs))
        left = [h for k, h in enumerate(left) if k not in pairs[best]] + [joined[best]]


def boxes_touch(first, second):
    low = np.maximum(first.points.min(axis=0), second.points.min(axis=0))
    high = np.minimum(first.points.max(axis=0), second.points.max(axis=0))
    return bool((low <= high).all())


def outside(points, of):
    planes = ConvexHull(of).equations
    return float((points @ planes[:, :3].T + planes[:, 3]).max())


@pytest.mark.parametrize("most", [4, 10, 64])
def test_corners_are_kept_up_to_the_number_allowed(most):
    hull = hull_of(trimesh.creation.icosphere(3, 0.03).vertices)
    fewer, is_near = fewer_vertices(hull, most, 0.0, 0.0)
    assert len(fewer.points) == most
    assert not is_near
    assert np.isin(fewer.points, hull.points).all()
    assert fewer.volume == pytest.approx(ConvexHull(fewer.points).volume)


def test_corners_are_left_out_within_the_distance_and_the_volume():
    hull = hull_of(trimesh.creation.icosphere(3, 0.03).vertices)
    by_distance, is_near = fewer_vertices(hull, 9999, 0.001, 1.0)
    assert is_near
    assert len(by_distance.points) < 200
    assert 0.0005 < outside(hull.points, by_distance.points) <= 0.001
    by_volume, is_near = fewer_vertices(hull, 9999, 1.0, 0.02)
    assert is_near
    assert 0.98 * hull.volume <= by_volume.volume < 0.99 * hull.volume


def test_all_corners_of_a_box_with_points_on_its_faces_are_kept():
    box = trimesh.creation.box((1, 2, 3)).subdivide().subdivide()
    fewer, is_near = fewer_vertices(hull_of(np.asarray(box.vertices)), 8, 1e-9, 1e-9)
    assert is_near
    assert fewer.volume == pytest.approx(6)


def test_a_lowered_face_takes_a_slice_off_and_nothing_is_left_of_a_plate():
    planes = hull_of(trimesh.creation.box((2, 2, 2)).vertices).planes
    by = np.where(planes[:, 2] > 0.9, 0.25, 0.0)
    corners = lower_planes(planes, by, np.zeros(3))
    assert corners is not None
    assert hull_of(corners).volume == pytest.approx(8 - 0.25 * 4)
    assert corners[:, 2].max() == pytest.approx(0.75)
    assert lower_planes(planes, np.full(len(planes), 1.1), np.zeros(3)) is None

"""Hulls and joining them: exact volumes, bounds, and the order in which pairs are taken."""

import numpy as np
import pytest
import trimesh
from scipy.spatial import ConvexHull

from egad.geometry.hulls import Hull, hull_mesh, hull_of, least_volume, merge_hulls
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


def test_hulls_that_lie_apart_are_not_joined():
    apart = [block([10 * k, 0, 0], [10 * k + 1, 1, 1]) for k in range(3)]
    assert len(merge_hulls(apart, 99.0, always)) == 3


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


def slowly(hulls: list[Hull], allowed: float) -> list[Hull]:
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


def boxes_touch(first: Hull, second: Hull) -> bool:
    low = np.maximum(first.points.min(axis=0), second.points.min(axis=0))
    high = np.minimum(first.points.max(axis=0), second.points.max(axis=0))
    return bool((low <= high).all())

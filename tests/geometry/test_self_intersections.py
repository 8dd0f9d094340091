from itertools import combinations

import numpy as np
import trimesh

from egad.geometry.self_intersections import crossings


def pierces(edges_of, triangle):
    """Solve edge = plane in barycentric coordinates, the obvious way."""
    a, b, c = triangle
    for p, q in zip(edges_of, np.roll(edges_of, -1, axis=0), strict=True):
        u, v, t = np.linalg.solve(np.column_stack([b - a, c - a, p - q]), p - a)
        if u >= 0 and v >= 0 and u + v <= 1 and 0 < t < 1:
            return True
    return False


def test_random_triangles_cross_where_the_linear_systems_say():
    corners = np.random.default_rng(5).normal(size=(120, 3, 3)) * [1, 2, 0.5]
    corners += np.random.default_rng(6).normal(size=(120, 1, 3)) * 2
    slow = {
        (i, j)
        for i, j in combinations(range(120), 2)
        if pierces(corners[i], corners[j]) or pierces(corners[j], corners[i])
    }
    found = crossings(corners.reshape(-1, 3), np.arange(360).reshape(-1, 3), 0.0)
    assert len(slow) > 50
    assert {tuple(sorted(pair)) for pair in found.tolist()} == slow


def test_a_closed_surface_does_not_cross_itself():
    ball = trimesh.creation.icosphere(subdivisions=3)
    assert len(crossings(ball.vertices, ball.faces, 0.0)) == 0
    block = trimesh.creation.box()  # neighbors lie in one plane
    assert len(crossings(block.vertices, block.faces, 0.0)) == 0


def test_two_balls_in_one_mesh_cross_in_a_ring():
    ball = trimesh.creation.icosphere(subdivisions=3)
    both = trimesh.util.concatenate([ball, ball.copy().apply_translation([1.0, 0.03, 0.02])])
    found = crossings(both.vertices, both.faces, 1e-6)
    centers = both.triangles_center[np.unique(found)]
    assert len(found) > 30
    assert np.allclose(centers[:, 0], 0.5, atol=0.15)


def test_shallow_crossings_are_noise():
    triangles = np.array([[[0, 0, 0], [4, 0, 0], [0, 4, 0]], [[1, 1, -0.01], [1, 1, 3], [9, 9, 3]]])
    vertices, faces = triangles.reshape(-1, 3).astype(float), np.arange(6).reshape(-1, 3)
    assert len(crossings(vertices, faces, 0.009)) == 1
    assert len(crossings(vertices, faces, 0.011)) == 0


def test_nothing_crosses_in_nothing():
    assert crossings(np.empty((0, 3)), np.empty((0, 3), dtype=int), 0.0).shape == (0, 2)

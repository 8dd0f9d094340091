import manifold3d
import numpy as np
import pytest
import trimesh

from egad.geometry.manifold import to_mesh
from egad.geometry.surface_samples import TURN, rims, spread


def test_points_lie_on_their_triangles_and_close_together():
    mesh = trimesh.creation.box((3, 2, 1))
    found = spread(mesh, 0.3)
    corners, normals = mesh.triangles[found.faces], mesh.face_normals[found.faces]
    assert np.einsum("nk,nk->n", found.points - corners[:, 0], normals) == pytest.approx(0)
    assert (found.normals == normals).all()
    corner = trimesh.triangles.points_to_barycentric(corners, found.points)
    assert (corner > 0).all()
    dense = np.random.default_rng(0).uniform([-1.5, -1, 0.5], [1.5, 1, 0.5], (300, 3))
    away = np.linalg.norm(dense[:, None] - found.points, axis=2).min(axis=1)
    assert away.max() < 0.3


def step():
    """A cube of 2 with a cube of 1 on top: four reflex edges of length 1."""
    low = manifold3d.Manifold.cube((2, 2, 2), True)
    return to_mesh(low + manifold3d.Manifold.cube((1, 1, 2), True).translate((0, 0, 1)))


def test_a_ball_rolls_around_reflex_edges_only():
    points, normals = rims(step(), 0.3)
    assert points[:, 2] == pytest.approx(1)
    assert np.abs(points[:, :2]).max(axis=1) == pytest.approx(0.5)
    assert np.linalg.norm(normals, axis=1) == pytest.approx(1)
    assert len(points) == 4 * 4 * (int(np.ceil(np.pi / 2 / TURN)) + 1)
    around = normals[np.linalg.norm(points - points[0], axis=1) < 1e-9]
    angles = np.arccos(np.clip(np.einsum("nk,nk->n", around[1:], around[:-1]), -1, 1))
    assert angles.max() <= TURN
    assert angles.sum() == pytest.approx(np.pi / 2)


def test_a_convex_body_has_no_reflex_edges():
    assert rims(trimesh.creation.box((1, 1, 1)), 0.1)[0].shape == (0, 3)

import numpy as np
import pytest
import trimesh

from egad.geometry.surface_samples import spread


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

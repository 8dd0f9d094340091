import manifold3d
import numpy as np
import pytest
import trimesh

from egad.evalset.printability import TURN, rims
from egad.geometry.manifold import to_mesh


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

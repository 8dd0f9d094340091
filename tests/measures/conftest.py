import numpy as np
import pytest
import trimesh

from egad.measures.refine import triangulation


@pytest.fixture
def lumpy():
    """A closed mesh without symmetries, 162 vertices."""
    mesh = trimesh.creation.icosphere(subdivisions=2)
    directions = np.random.default_rng(0).normal(size=(6, 3))
    mesh.vertices *= 1 + 0.1 * np.sin(2 * mesh.vertices @ directions.T).sum(axis=1, keepdims=True)
    return mesh


@pytest.fixture
def triangulate():
    return lambda mesh: triangulation(np.array(mesh.vertices), np.array(mesh.faces, np.int32))

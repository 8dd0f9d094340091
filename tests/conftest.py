import numpy as np
import pytest
import trimesh


@pytest.fixture(scope="session")
def spiky_box():
    """Makes a box of random sides with random spikes, the same for the same number."""

    def make(number):
        rng = np.random.default_rng(number)
        mesh = trimesh.creation.box(extents=rng.uniform(0.2, 1, 3)).subdivide().subdivide()
        mesh.vertices[rng.random(len(mesh.vertices)) < 0.3] *= rng.uniform(0.6, 1.5)
        return mesh

    return make

"""What a camera sees of a mesh on the table."""

import pytest
import trimesh

from egad.vision.camera import Eye, Intrinsics, View, above


@pytest.fixture(scope="session")
def look():
    """From a mesh that stands at (x, y), turned about the vertical, to a view of it."""

    def seen(mesh, x=0.0, y=0.0, turn=0.0, size=300) -> View:
        matrix = trimesh.transformations.rotation_matrix(turn, (0, 0, 1))
        matrix[:3, 3] = [x, y, -mesh.bounds[0, 2]]
        return Eye(mesh).look(matrix, Intrinsics.spanning(size, size, 40.0), above(0.6))

    return seen

import numpy as np
import pytest

from egad.evolution import Shape
from egad.evolution.surface import surface

SHAPE = Shape()


def ball(size=25):
    line = np.linspace(-1, 1, size)
    x, y, z = np.meshgrid(line, line, line, indexing="ij")
    return x**2 + y**2 + z**2 < 0.8


def test_a_ball_is_a_watertight_ball_with_outward_normals():
    mesh = surface(ball(), SHAPE)
    assert mesh.is_watertight
    assert mesh.extents.max() == pytest.approx(SHAPE.longest_side)
    assert np.allclose(mesh.bounds.sum(axis=0), 0, atol=1e-12)
    assert mesh.volume == pytest.approx(4 / 3 * np.pi * 0.05**3, rel=0.05)  # inside out: negative
    outward = np.einsum("ij,ij->i", mesh.face_normals, mesh.triangles_center)
    assert (outward > 0).all()


def test_a_solid_that_touches_the_border_is_closed():
    mesh = surface(np.ones((8, 8, 8), bool), SHAPE)
    assert mesh.is_watertight
    assert mesh.euler_number == 2


def test_smoothing_rounds_a_cube_and_no_rounds_leave_it():
    cube = np.zeros((25, 25, 25), bool)
    cube[5:20, 5:20, 5:20] = True
    areas = [
        surface(cube, SHAPE.model_copy(update={"smoothing_iterations": n})).area for n in (0, 10)
    ]
    assert areas[1] < areas[0]

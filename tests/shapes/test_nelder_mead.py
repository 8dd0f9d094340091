"""Against SciPy, bit for bit."""

import numpy as np
import pytest
from scipy.optimize import minimize, rosen
from scipy.spatial.transform import Rotation

from egad.shapes.nelder_mead import SMALL, minimum, rotation_matrix


@pytest.mark.parametrize("size", [0, 1e-9, 0.9 * SMALL, 1.1 * SMALL, 0.1, 1, 3, 10])
def test_rotation_matrix_is_that_of_scipy(size: float) -> None:
    for direction in np.random.default_rng(0).normal(size=(50, 3)):
        vector = size * direction / np.linalg.norm(direction)
        expected = Rotation.from_rotvec(vector).as_matrix()
        np.testing.assert_array_equal(rotation_matrix(tuple(vector.tolist())), expected)


def _bumpy(place: tuple[float, float, float]) -> float:
    """Has creases and many minima: all kinds of steps are taken."""
    x, y, z = place
    return max(abs(x - 0.3), abs(y + z), abs(z - x * y)) + 0.2 * np.sin(9 * x) * np.cos(7 * y)


@pytest.mark.parametrize("function", [rosen, _bumpy])
@pytest.mark.parametrize("most", [2, 7, 300])
def test_minimum_is_that_of_scipy(function, most: int) -> None:
    rng = np.random.default_rng(1)
    for simplex in rng.normal(size=(20, 4, 3)):
        options = {"initial_simplex": simplex, "xatol": 1e-3, "fatol": 1e-4, "maxiter": most}
        expected = minimize(function, simplex[0], method="Nelder-Mead", options=options)
        corners = [tuple(corner) for corner in simplex.tolist()]
        found = minimum(function, corners, xatol=1e-3, fatol=1e-4, maxiter=most)
        np.testing.assert_array_equal(found, expected.x)


def test_minimum_ends_at_once_where_all_is_alike() -> None:
    calls = []

    def flat(place: tuple[float, float, float]) -> float:
        calls.append(place)
        return 1.0

    simplex = [(0.0, 0.0, 0.0), (1e-4, 0.0, 0.0), (0.0, 1e-4, 0.0), (0.0, 0.0, 1e-4)]
    assert minimum(flat, simplex, xatol=1e-3, fatol=1e-4, maxiter=300) == (0.0, 0.0, 0.0)
    assert len(calls) == 4

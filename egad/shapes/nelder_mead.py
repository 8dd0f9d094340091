"""The minimum of a quick function of a rotation vector, and the matrix of such a vector.

Both are what SciPy computes, to the last bit, in plain floats: for three numbers the overhead of
SciPy's functions is many times the work.
"""

import math
from collections.abc import Callable
from operator import itemgetter

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Vector = tuple[float, float, float]
Corner = tuple[float, Vector]  # value and place

SMALL = 1e-3  # radians: below this a series is more accurate than the sine
_value = itemgetter(0)


def rotation_matrix(vector: Vector) -> Floats:
    """The matrix (3, 3) of `scipy.spatial.transform.Rotation.from_rotvec`."""
    x, y, z = vector
    angle = math.sqrt(x * x + y * y + z * z)
    square = angle * angle
    series = 0.5 - square / 48 + square * square / 3840
    scale = series if angle <= SMALL else math.sin(angle / 2) / angle
    x, y, z, w = scale * x, scale * y, scale * z, math.cos(angle / 2)
    xx, yy, zz, ww = x * x, y * y, z * z, w * w
    return np.array(
        [
            [xx - yy - zz + ww, 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), -xx + yy - zz + ww, 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), -xx - yy + zz + ww],
        ]
    )


def minimum(
    function: Callable[[Vector], float],
    simplex: list[Vector],
    *,
    xatol: float,
    fatol: float,
    maxiter: int,
) -> Vector:
    """Where a function is least, as far as the steps of Nelder and Mead (1965) lead.

    The result is that of `scipy.optimize.minimize(..., method="Nelder-Mead")`.

    Args:
        function: Of three numbers.
        simplex: Four corners to start from.
        xatol: The search ends when the other corners are this near to the best, along each axis,
        fatol: and their values as near to its value.
        maxiter: It also ends after one step less than this.
    """
    corners = sorted(((function(place), place) for place in simplex), key=_value)
    for _ in range(1, maxiter):
        if corners[3][0] - corners[0][0] <= fatol and _size(corners) <= xatol:
            break
        corners = sorted(_step(function, corners), key=_value)
    return corners[0][1]


def _step(function: Callable[[Vector], float], corners: list[Corner]) -> list[Corner]:
    """Replace the worst of four corners, which are sorted, or draw all to the best."""
    (lowest, _), (third, _), (highest, worst) = corners[0], corners[2], corners[3]
    a, b, c = (place for _, place in corners[:3])
    middle = [(p + q + r) / 3 for p, q, r in zip(a, b, c, strict=True)]

    def mirrored(part: float) -> Corner:
        x, y, z = ((1 + part) * m - part * w for m, w in zip(middle, worst, strict=True))
        return function((x, y, z)), (x, y, z)

    new = mirrored(1)
    if new[0] < lowest:
        return [*corners[:3], min(new, mirrored(2), key=_value)]
    if new[0] < third:
        return [*corners[:3], new]
    inner = mirrored(0.5 if new[0] < highest else -0.5)
    if inner[0] <= new[0] < highest or inner[0] < highest <= new[0]:
        return [*corners[:3], inner]
    drawn = [_between(a, place) for _, place in corners[1:]]
    return [corners[0], *((function(place), place) for place in drawn)]


def _between(best: Vector, other: Vector) -> Vector:
    """The point halfway from the best corner to another."""
    x, y, z = (p + 0.5 * (q - p) for p, q in zip(best, other, strict=True))
    return x, y, z


def _size(corners: list[Corner]) -> float:
    """How far the corners are from the first, along the axis where it is most."""
    best = corners[0][1]
    pairs = (zip(place, best, strict=True) for _, place in corners[1:])
    return max(abs(p - q) for pair in pairs for p, q in pair)

"""Checks of numbers and arrays given to public functions: a wrong one is a `UserError`."""

import math
from contextlib import suppress
from typing import SupportsFloat

import numpy as np

from egad._util.arrays import Floats
from egad.errors import UserError


def check_positive(name: str, given: object, most: float = math.inf) -> float:
    """A number, not a string, as a float above 0 and at most `most`; otherwise `UserError`."""
    number = math.nan
    if isinstance(given, SupportsFloat) and not isinstance(given, bool):
        with suppress(TypeError, ValueError):  # arrays raise them
            number = float(given)
    if not (0 < number <= most and math.isfinite(number)):
        kind, limit = "a number", f", at most {most:g}"
        if math.isinf(most):
            kind, limit = "a finite number", ""
        raise UserError(f"{name} is {given!r}; allowed: {kind}, above 0{limit}")
    return number


def check_array(name: str, given: object, shape: tuple[int, ...], allowed: str) -> Floats:
    """An argument as an array of finite numbers, or `UserError` that says what is `allowed`."""
    array = as_floats(given)
    if array is None or array.shape != shape or not np.isfinite(array).all():
        raise UserError(f"{name} is {given!r}; allowed: {allowed}")
    return array


def as_floats(given: object) -> Floats | None:
    """An array of numbers, of any shape; None if it is something else, such as ragged rows."""
    with suppress(TypeError, ValueError):
        return np.asarray(given, dtype=np.float64)
    return None

"""Measures that a user brings: functions in files of their own, named `FILE.py:FUNCTION`."""

import math
from collections.abc import Callable
from typing import Any

import trimesh

from egad import plugins as own_code
from egad.errors import RejectedError
from egad.measures.parameters import Axes

Measure = Callable[[trimesh.Trimesh], Any]
WHERE = "axes"


def own_value(measure: str, mesh: trimesh.Trimesh) -> float:
    """The value of a user's measure.

    Args:
        measure: `FILE.py:FUNCTION` or `package.module:FUNCTION`.
        mesh: Closed, in metres; the function gets a copy.

    Raises:
        RejectedError: The function fails, or gives no finite number.
        UserError: There is no such function.
    """
    function, name = _function(measure), own_name(measure)
    try:
        given = function(mesh.copy())
        value = float(given)
    except MemoryError:
        raise  # says nothing of the object
    except Exception as error:
        raise RejectedError(f"{name} failed: {type(error).__name__}: {error}") from error
    if not math.isfinite(value):
        raise RejectedError(f"{name} is not a finite number ({value})")
    return value


def own_name(measure: str) -> str:
    """What a measure is called: its function, in words."""
    return measure.rpartition(":")[2].replace("_", " ").strip()


def check_measures(axes: Axes) -> None:
    """Make sure that the user's measures are there.

    Raises:
        UserError: One is not.
    """
    for _, measure in axes:
        if measure:
            _function(measure)


def source_hash(measure: str) -> str:
    """A fingerprint of the file that a measure is written in, which is not run.

    Raises:
        UserError: There is no such file.
    """
    return own_code.source_hash(measure, WHERE)


def _function(measure: str) -> Measure:
    found: Measure = own_code.find(measure, WHERE, "function")
    return found

"""User-defined measures: functions in files of their own, named `FILE.py:FUNCTION`."""

import inspect
import math
from collections.abc import Callable
from typing import Any

import trimesh

from egad import plugins
from egad.errors import RejectedError
from egad.measures.parameters import CustomMeasures

Measure = Callable[..., Any]  # of a trimesh.Trimesh, and of parameters by name
WHERE = "measures"


def plugin_value(measure: str, mesh: trimesh.Trimesh, axes: CustomMeasures | None = None) -> float:
    """The value of a user's measure of a closed mesh, metres; `RejectedError` if it fails."""
    function, name = _function(measure), plugin_name(measure)
    parameters = (axes or CustomMeasures()).parameters()
    try:
        names = inspect.signature(function).parameters if parameters else {}
        used = {key: value for key, value in parameters.items() if key in names}
        given = function(mesh.copy(), **used)
    except MemoryError:
        raise  # says nothing about the object
    except Exception as error:
        what = f"{plugins.place_of(error)}: {type(error).__name__}: {error}"
        raise RejectedError(f"{name} failed{what}") from error
    try:
        value = float(given)
    except (TypeError, ValueError, OverflowError) as error:
        raise RejectedError(f"{name} must be a number, got {type(given).__name__}") from error
    if not math.isfinite(value):
        raise RejectedError(f"{name} is not a finite number ({value})")
    return value


def plugin_name(measure: str) -> str:
    """Display name of a measure: its function, in words."""
    return measure.rpartition(":")[2].replace("_", " ").strip()


def check_measures(axes: CustomMeasures) -> None:
    """Raise `UserError` if one of the user's measures does not exist."""
    for measure in axes.functions().values():
        _function(measure)


def source_hash(measure: str) -> str:
    """A fingerprint of the file that defines a measure, which is not run; `UserError` if none."""
    return plugins.source_hash(measure, WHERE)


def _function(measure: str) -> Measure:
    found: Measure = plugins.find(measure, WHERE, "function")
    return found

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
    function: Measure = plugins.find(measure, WHERE, "function")
    name, parameters = plugin_name(measure), (axes or CustomMeasures()).parameters()

    def run() -> Any:  # noqa: ANN401 (whatever it gives)
        names = inspect.signature(function).parameters if parameters else {}
        used = {key: value for key, value in parameters.items() if key in names}
        return function(mesh.copy(), **used)

    given = plugins.call(name, run)
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
        plugins.find(measure, WHERE, "function")

"""Measures that a user brings: functions in files of their own, named `FILE.py:FUNCTION`."""

import hashlib
import importlib
import importlib.util
import math
import sys
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from types import ModuleType
from typing import Any

import trimesh

from egad.errors import RejectedError, UserError
from egad.settings import Axes

Measure = Callable[[trimesh.Trimesh], Any]


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
    """A fingerprint of the file that a measure is written in; nothing in it is run.

    Raises:
        UserError: There is no such file.
    """
    path = _source(measure.rpartition(":")[0], measure)
    return hashlib.sha256(path.read_bytes()).hexdigest()[:16]


@lru_cache
def _function(measure: str) -> Measure:
    module, _, name = measure.rpartition(":")
    path = _source(module, measure)
    try:
        found: Measure | None = getattr(_loaded(module, path), name, None)
    except Exception as error:
        raise UserError(f"axes: {path} cannot be run: {type(error).__name__}: {error}") from error
    if found is None or not callable(found):
        raise UserError(f"axes: there is no function {name} in {path}")
    return found


def _source(module: str, measure: str) -> Path:
    """The file of a module."""
    path = Path(module) if module.endswith(".py") else _installed(module)
    if path is None or not path.is_file():
        raise UserError(f"axes: {measure}: there is no such file or module")
    return path


def _installed(module: str) -> Path | None:
    try:
        spec = importlib.util.find_spec(module)
    except (ImportError, ValueError):
        return None
    return Path(spec.origin) if spec is not None and spec.origin is not None else None


def _loaded(module: str, path: Path) -> ModuleType:
    if not module.endswith(".py"):
        return importlib.import_module(module)
    spec = importlib.util.spec_from_file_location(f"egad_axis_{path.stem}", path)
    if spec is None or spec.loader is None:
        raise ImportError(f"{path} is not Python")
    loaded = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = loaded  # dataclasses look for it
    spec.loader.exec_module(loaded)
    return loaded

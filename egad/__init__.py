"""Evolved objects for robot grasping: load, measure, scale, grasp, simulate and evolve them.

Everything that `__init__.pyi` lists is imported when it is first used, so `import egad` is quick.
"""

from typing import Any

import lazy_loader

from egad._util.extras import needed_for as _needed_for
from egad._util.memory import check_memory as _check_memory

__version__ = "0.1.0"

_load, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def __getattr__(name: str) -> Any:  # noqa: ANN401 (whatever it is)
    _check_memory()
    with _needed_for(f"egad.{name}"):
        return _load(name)

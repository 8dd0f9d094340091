"""EGAD: evolved objects for robot grasping, as a reproducible pipeline."""

from typing import TYPE_CHECKING, Any

from egad._util.kernel_cache import use_own_cache

if TYPE_CHECKING:
    from egad.exchange.grasps import load_grasps

__all__ = ["__version__", "load_grasps"]
__version__ = "0.1.0"

use_own_cache()


def __getattr__(name: str) -> Any:  # noqa: ANN401 (whatever the name stands for)
    """Import what the package offers only when it is asked for: `import egad` is quick."""
    if name == "load_grasps":
        from egad.exchange.grasps import load_grasps  # noqa: PLC0415

        return load_grasps
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

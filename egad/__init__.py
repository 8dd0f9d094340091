"""EGAD: evolved objects for robot grasping, as a reproducible pipeline."""

from egad.kernel_cache import use_own_cache

__version__ = "0.1.0"

use_own_cache()

"""EGAD: evolved objects for robot grasping, as a reproducible pipeline."""

__version__ = "0.1.0"

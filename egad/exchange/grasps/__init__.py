"""Formats of grasps: one module a format."""

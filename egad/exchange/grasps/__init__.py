"""Formats of grasps: one module per format."""

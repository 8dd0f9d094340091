"""Formats of objects with convex parts, mass and friction: one module per format."""

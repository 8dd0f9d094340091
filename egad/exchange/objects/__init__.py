"""Formats of objects with convex parts, mass and friction: one module a format."""

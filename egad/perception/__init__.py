"""Depth cameras, sensor noise, and rendered images of objects with their grasps."""

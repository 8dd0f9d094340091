"""Meshes and solids: repair, mass, scaling, distances, convex parts, stable poses."""

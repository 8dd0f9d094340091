"""Meshes and solids: repair, mass, scaling, distances, convex parts, poses at rest."""

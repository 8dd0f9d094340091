"""Depth images of objects on a table, and where their grasps are in them."""

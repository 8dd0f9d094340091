"""Measures to take as axes of the space: functions from a closed mesh in metres to a number."""

import numpy as np
import trimesh


def elongation(mesh: trimesh.Trimesh) -> float:
    """Longest side of the minimum-volume box over its middle one: 1 for a cube or a plate."""
    sides = np.sort(mesh.bounding_box_oriented.primitive.extents)
    return float(sides[2] / sides[1])


def hollowness(mesh: trimesh.Trimesh) -> float:
    """The part of the convex hull that is empty: 0 for convex shapes."""
    return float(1 - mesh.volume / mesh.convex_hull.volume)

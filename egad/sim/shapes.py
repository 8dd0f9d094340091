"""Shapes of robots and walls: boxes and convex hulls."""

from dataclasses import dataclass

import numpy as np
import trimesh

from egad._util.arrays import Floats

Vector = tuple[float, float, float]
WALL_HEIGHT, WALL_THICKNESS = 0.4, 0.05  # metres


@dataclass(frozen=True)
class Box:
    """A box whose sides are parallel to the axes of its link: lengths and center, metres."""

    size: Vector
    center: Vector


@dataclass(frozen=True, eq=False)
class HullShape:
    """The convex hull of points, (n, 3) in the frame of the link, metres."""

    points: Floats


def corners(shape: Box | HullShape) -> Floats:
    """Points that a shape is the hull of, or two opposite corners of a box."""
    if isinstance(shape, HullShape):
        return shape.points
    half = np.array(shape.size) / 2
    return np.array([shape.center - half, shape.center + half])


def vector(values: Floats) -> Vector:
    """Three numbers as a tuple of floats."""
    x, y, z = map(float, values)
    return x, y, z


def shape_mesh(shape: Box | HullShape) -> trimesh.Trimesh:
    """A shape in the frame of its link, metres."""
    if isinstance(shape, HullShape):
        hull: trimesh.Trimesh = trimesh.convex.convex_hull(shape.points)
        return hull
    mesh: trimesh.Trimesh = trimesh.creation.box(shape.size)
    mesh.apply_translation(shape.center)
    return mesh


def wall_boxes(inside: float) -> list[Box]:
    """Four boxes around a square of the table with the given side, metres."""
    along, off = inside + 2 * WALL_THICKNESS, (inside + WALL_THICKNESS) / 2
    across = [
        Box((WALL_THICKNESS, along, WALL_HEIGHT), (x, 0.0, WALL_HEIGHT / 2)) for x in (-off, off)
    ]
    return across + [
        Box((along, WALL_THICKNESS, WALL_HEIGHT), (0.0, y, WALL_HEIGHT / 2)) for y in (-off, off)
    ]

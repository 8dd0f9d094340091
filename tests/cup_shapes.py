"""Meshes and poses of cups for the tests."""

import numpy as np
import trimesh

from egad.geometry import RayCaster

DOWN = np.array([[1.0, 0, 0], [0, -1, 0], [0, 0, -1]])  # x, y, z of a cup that comes from above


def box(side=0.06):
    return trimesh.creation.box([side] * 3)


def sphere(radius):
    return trimesh.creation.icosphere(subdivisions=5, radius=radius)


def cylinder(radius, length=0.4):
    """Along y."""
    mesh = trimesh.creation.cylinder(radius, length, sections=360)
    return mesh.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [1, 0, 0]))


def from_above(mesh, points):
    """A caster, and cups that come along -z over points (n, 2), which all lie above the mesh."""
    caster = RayCaster(mesh)
    points = np.asarray(points, dtype=float).reshape(-1, 2)
    high = np.column_stack([points, np.full(len(points), mesh.bounds[1, 2] + 1)])
    down = np.tile([0.0, 0, -1], (len(points), 1))
    depth = caster.first_hits(high, down).distances
    return caster, high + depth[:, None] * down, np.tile(DOWN, (len(points), 1, 1))

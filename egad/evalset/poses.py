"""How an object lies on the bed of a printer: poses, overhangs, the first layer (ours)."""

from typing import NamedTuple

import numpy as np
import trimesh
from numpy.typing import NDArray

from egad.shapes.manifold import to_solid

Floats = NDArray[np.float64]

LAYER = 0.0002  # metres
LIKELY = 0.02  # poses that an object comes to rest in less often are too shaky to print in


class Pose(NamedTuple):
    """An object lying on the bed, in metres, the lowest corner of its box at the origin.

    Attributes:
        mesh: The turned object, the longer side of its footprint along x.
        probability: Chance of coming to rest like this when dropped; NaN if there is no pose.
        overhang: Area that needs support, m2.
        contact: Area of the first layer, m2.
    """

    mesh: trimesh.Trimesh
    probability: float
    overhang: float
    contact: float


def lie_down(mesh: trimesh.Trimesh, choice: str, angle: float) -> Pose:
    """A copy in one of its resting poses.

    Args:
        mesh: A closed surface, wound outwards, metres.
        choice: `stable`: the most probable pose; `overhang`: of all but the improbable ones, the
            one with the least area to support.
        angle: Surface that leans out further from the vertical is supported, degrees.
    """
    poses, chances = trimesh.poses.compute_stable_poses(mesh, sigma=0, n_samples=1)
    if len(poses) == 0:
        return _pose(mesh, np.eye(4), np.nan, angle)
    order = np.argsort(-np.asarray(chances), kind="stable")
    likely = [place for place in order if chances[place] >= LIKELY] or [order[0]]
    if choice == "overhang":
        areas = [overhang_area(mesh, poses[place], angle) for place in likely]
        likely = [likely[int(np.argmin(areas))]]
    return _pose(mesh, poses[likely[0]], float(chances[likely[0]]), angle)


def _pose(mesh: trimesh.Trimesh, turn: Floats, probability: float, angle: float) -> Pose:
    turned = mesh.copy()
    turned.apply_transform(turn)
    turned.apply_transform(_align_with_bed(turned))
    turned.apply_translation(-turned.bounds[0])
    clean = trimesh.Trimesh(turned.vertices, turned.faces, process=False)
    area = overhang_area(clean, np.eye(4), angle)
    return Pose(clean, probability, area, first_layer_area(clean))


def overhang_area(mesh: trimesh.Trimesh, turn: Floats, angle: float) -> float:
    """Area of the surface that needs support: it faces down and does not lie on the bed.

    Args:
        mesh: A closed surface, wound outwards.
        turn: (4, 4); after it z points up.
        angle: Surface that leans out further from the vertical counts, degrees.
    """
    up = np.asarray(turn)[2, :3]
    heights = np.asarray(mesh.vertices) @ up
    above = heights[mesh.faces].max(axis=1) > heights.min() + LAYER
    leaning = np.asarray(mesh.face_normals) @ up < -np.sin(np.radians(angle))
    return float(np.asarray(mesh.area_faces)[above & leaning].sum())


def first_layer_area(mesh: trimesh.Trimesh) -> float:
    """Area of the section through the middle of the first layer of an object on the bed."""
    solid = to_solid(mesh.vertices, mesh.faces)
    return float(solid.slice(float(mesh.bounds[0, 2]) + LAYER / 2).area())


def _align_with_bed(mesh: trimesh.Trimesh) -> Floats:
    """The turn about the vertical that makes the rectangle around a mesh smallest."""
    flat, sides = trimesh.bounds.oriented_bounds_2D(mesh.vertices[:, :2])
    turn = np.eye(4)
    turn[:2, :2] = flat[:2, :2]
    if sides[1] > sides[0]:
        turn[:2] = [-turn[1], turn[0]]
    return turn

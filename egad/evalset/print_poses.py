"""How an object lies on the bed of a printer: poses, overhangs, the first layer (ours)."""

from typing import NamedTuple

import numpy as np
import trimesh

from egad._util.arrays import Floats
from egad.errors import RejectedError
from egad.geometry import mass_properties, resting_poses, to_solid

LAYER = 0.0002  # metres
OVERHANG_ANGLE = 40.0  # degrees to the vertical, beyond which surface is supported
LIKELY = 0.02  # poses that an object comes to rest in less often are too shaky to print in
FOOTHOLD = 1e-6  # m2: slicers leave out a first layer much smaller than this


class PrintPose(NamedTuple):
    """An object lying on the bed, metres and m2, the lowest corner of its box at the origin.

    Overhangs need support; contact is the area of the first layer. The probability is that of
    coming to rest like this when dropped; NaN if there is no pose.
    """

    mesh: trimesh.Trimesh
    probability: float
    overhang: float
    contact: float


def lie_down(mesh: trimesh.Trimesh, choice: str, along: int = 0) -> PrintPose:
    """A copy in one of its resting poses, the longer side of its footprint along an axis.

    `stable`: on the face of its hull that it most probably comes to rest on; `overhang`: among all
    but the improbable poses, the one with the least area to support, if possible with a first layer
    of 1 mm2.
    """
    try:
        poses = resting_poses(mesh, mass_properties(mesh, 1.0).com)
    except RejectedError:
        return _pose(mesh, np.eye(3), np.nan, along)
    chosen = poses[0]
    if choice == "overhang":
        likely = [pose for pose in poses if pose.probability >= LIKELY] or [chosen]
        likely.sort(key=lambda pose: overhang_area(mesh, pose.rotation))
        firm = (pose for pose in likely if first_layer_area(mesh, pose.rotation) >= FOOTHOLD)
        chosen = next(firm, likely[0])
    return _pose(mesh, chosen.rotation, chosen.probability, along)


def _pose(mesh: trimesh.Trimesh, rotation: Floats, probability: float, along: int) -> PrintPose:
    standing = np.asarray(mesh.vertices, dtype=np.float64) @ rotation.T
    turned = standing @ _align_with_bed(standing, along).T
    clean = trimesh.Trimesh(turned - turned.min(axis=0), mesh.faces, process=False)
    area = overhang_area(clean, np.eye(3))
    return PrintPose(clean, probability, area, first_layer_area(clean, np.eye(3)))


def overhang_area(mesh: trimesh.Trimesh, rotation: Floats, angle: float = OVERHANG_ANGLE) -> float:
    """Area that needs support: steeper than an angle (degrees), facing down, not on the bed.

    After the rotation, z points up. Overhangs at a larger angle to the vertical count.
    """
    up = rotation[2]
    heights = np.asarray(mesh.vertices) @ up
    above = heights[mesh.faces].max(axis=1) > heights.min() + LAYER
    leaning = np.asarray(mesh.face_normals) @ up < -np.sin(np.radians(angle))
    return float(np.asarray(mesh.area_faces)[above & leaning].sum())


def first_layer_area(mesh: trimesh.Trimesh, rotation: Floats) -> float:
    """Area of the section through the middle of the first layer; the rotation turns z up."""
    standing = np.asarray(mesh.vertices, dtype=np.float64) @ rotation.T
    return float(to_solid(standing, mesh.faces).slice(standing[:, 2].min() + LAYER / 2).area())


def _align_with_bed(points: Floats, along: int) -> Floats:
    """The rotation about z, (3, 3), that makes the rectangle around points smallest.

    Its longer side lies along an axis.
    """
    flat, sides = trimesh.bounds.oriented_bounds_2D(points[:, :2])
    turn = np.eye(3)
    turn[:2, :2] = flat[:2, :2]
    if sides[1 - along] > sides[along]:
        turn[:2] = np.array([-turn[1], turn[0]])
    return turn

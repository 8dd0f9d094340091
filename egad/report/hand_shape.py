"""The shape of a hand in the colors of the 3D viewer, alone and at a grasp."""

import numpy as np
import pandas as pd
import trimesh
from numpy.typing import NDArray

from egad._util.arrays import Floats
from egad.geometry import joined
from egad.grasps import hand_poses, vectors
from egad.grippers import BoxBody, Gripper, HandModel, SuctionCup, model_of

Colored = tuple[trimesh.Trimesh, int]
Painted = tuple[trimesh.Trimesh, NDArray[np.uint8]]

# Numbers of the colors in scene3d.js; those of links by what they belong to
LINK_COLORS = {0: 0, -1: 1, 1: 2}
BOX_COLORS = (1, 2, 0)  # of the first finger, the second one, and the palm
OBJECT_COLOR = 5
CIRCLE = 32  # corners of a drawn circle


def link_shapes(model: HandModel, opening: float) -> list[Colored]:
    """The convex parts of a hand from a file, at an opening (m), in its own frame, with colors."""
    return [
        (trimesh.convex.convex_hull(points), LINK_COLORS[link.body])
        for link, shapes in zip(model.links, model.points(opening), strict=True)
        for points in shapes
    ]


def painted(shapes: list[Colored]) -> Painted:
    """Several meshes as one, and the color of each of its faces."""
    counts = [len(mesh.faces) for mesh, _ in shapes]
    paint = np.repeat([color for _, color in shapes], counts).astype(np.uint8)
    return joined(mesh for mesh, _ in shapes), paint


def best_grasp(mesh: trimesh.Trimesh, grasps: pd.DataFrame, gripper: Gripper) -> Painted | None:
    """An object (metres) with the hand closed at its best collision-free grasp; None without one.

    Grasps are columns of `tables.grasping.GRASPS`, in the frame of the mesh. A mesh for the palm is
    shown as a box. UserError if the file of the gripper cannot be used.
    """
    free = grasps[grasps["collision_free"].astype(bool)]
    if free.empty:
        return None
    best = free.iloc[[int(free["quality"].argmax())]]
    (pose,) = hand_poses(*(vectors(best, name) for name in ("center", "axis", "approach")))
    opening = float(best["width"].iloc[0])
    hand = [(shape.apply_transform(pose), color) for shape, color in hand_shapes(gripper, opening)]
    return painted([(mesh, OBJECT_COLOR), *hand])


def hand_shapes(gripper: Gripper, opening: float) -> list[Colored]:
    """The parts of a hand whose pads are around the origin, with colors."""
    if gripper.cup is not None:
        return _cup_shapes(gripper.cup)
    if gripper.file is not None:
        model = model_of(gripper)
        middle = model.middle_at(np.array(opening))
        return [
            (mesh.apply_translation(-middle), color) for mesh, color in link_shapes(model, opening)
        ]
    pieces = BoxBody(gripper).pieces(np.array([opening]))
    return [
        (trimesh.creation.box(bounds=part.box + each.shifts[0]), color)
        for each, color in zip(pieces, BOX_COLORS, strict=True)
        for part in each.parts
    ]


def _cup_shapes(cup: SuctionCup) -> list[Colored]:
    """The cup with its ring around the origin, and its stem behind it."""
    top = -cup.height
    flared = [_circle(cup.radius, 0.0), _circle(cup.stem_radius, top)]
    stem = [_circle(cup.stem_radius, top), _circle(cup.stem_radius, top - cup.stem_length)]
    return [
        (trimesh.convex.convex_hull(np.concatenate(rings)), color)
        for rings, color in ((flared, LINK_COLORS[1]), (stem, LINK_COLORS[0]))
    ]


def _circle(radius: float, height: float) -> Floats:
    turns = 2 * np.pi * np.arange(CIRCLE) / CIRCLE
    return np.stack([radius * np.cos(turns), radius * np.sin(turns), 0 * turns + height], axis=1)

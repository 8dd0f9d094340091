"""The shape of a hand in the colors of the 3D viewer, alone and at a grasp."""

from collections.abc import Iterable

import numpy as np
import pandas as pd
import trimesh
from numpy.typing import NDArray

from egad.geometry import joined
from egad.grasps import hand_poses, vectors
from egad.grippers import Gripper, body_of

Colored = tuple[trimesh.Trimesh, int]
Painted = tuple[trimesh.Trimesh, NDArray[np.uint8]]

# Numbers of the colors in scene3d.js; those of hands by what a part belongs to
LINK_COLORS = {0: 0, -1: 1, 1: 2}
OBJECT_COLOR = 5


def painted(shapes: list[Colored]) -> Painted:
    """Several meshes as one, and the color of each of its faces."""
    counts = [len(mesh.faces) for mesh, _ in shapes]
    paint = np.repeat([color for _, color in shapes], counts).astype(np.uint8)
    return joined(mesh for mesh, _ in shapes), paint


def best_grasp(mesh: trimesh.Trimesh, grasps: pd.DataFrame, gripper: Gripper) -> Painted | None:
    """An object (m) with the hand closed at its best collision-free grasp; None without one."""
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
    return colored(body_of(gripper).shapes(opening))


def colored(shapes: Iterable[tuple[trimesh.Trimesh, int]]) -> list[Colored]:
    """Shapes of a hand with the colors of what they belong to."""
    return [(mesh, LINK_COLORS[body]) for mesh, body in shapes]

"""A cube that stands on the table, and grasps of it from any direction."""

import numpy as np
import trimesh
from scipy.spatial.transform import Rotation

from egad.geometry import Bundle
from egad.grasps import hand_poses
from egad.sim.model import build
from egad.sim.world import Pose, World

SIDE = 0.04
CUBE = build(trimesh.creation.box((SIDE,) * 3), 1000.0, Bundle())
UPRIGHT = np.array([0.0, 0.0, 0.0, 1.0])
DOWN = [0.0, 0.0, -1.0]


def grasp(center: list[float], axis: list[float], approach: list[float]) -> np.ndarray:
    return np.asarray(
        hand_poses(*(np.array([each], float) for each in (center, axis, approach)))[0]
    )


def stand(world: World, height: float) -> None:
    upright = Rotation.from_matrix(world.model.to_principal[:3, :3].T).as_quat()
    world.place(Pose(np.array([0, 0, height / 2 + 1e-4]), upright), number=0)
    world.step(24)

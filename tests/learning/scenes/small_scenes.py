"""Scenes of few boxes, for tests."""

import trimesh

from egad.grippers import as_gripper
from egad.learning.scenes import SceneParameters, TrainingScenes

BOXES = {
    f"box{number}": trimesh.creation.box([0.028 + 0.003 * number, 0.045, 0.06])
    for number in range(6)
}
SPLIT_OF = dict(zip(BOXES, ["train"] * 3 + ["validation"] * 2 + ["test"], strict=True))
FEW = {"scenes": 4, "validation": 0.25, "test": 0.25, "objects": 2.0, "grasps": 8, "yaws": 3}


def parameters(**scenes):
    """Settings of few small scenes."""
    settings = TrainingScenes.model_validate(FEW | scenes)
    return SceneParameters(seed=13, gripper=as_gripper("panda"), scenes=settings)

"""Pictures of scenes: all objects in sight, and hands where the grasps are."""

from dataclasses import replace

import numpy as np
from small_scenes import parameters

from egad.learning.scenes.pictures import COLORS, FAILED, HELD, scene_picture

PANDA = parameters().gripper


def test_each_object_has_its_color_and_each_label_too(dataset):
    scene = next(each for each in map(dataset.scene, range(4)) if each.noise == "none")
    for view in range(scene.view_count):
        bare = scene_picture(replace(scene, grasps=scene.grasps.iloc[:0]), PANDA, view)
        assert bare.shape == (480, 640, 3)
        whole = bare.reshape(-1, 3).astype(float)
        shares = whole / np.maximum(whole.sum(axis=1, keepdims=True), 1)
        for number in np.unique(scene.views[view].mask[scene.views[view].mask > 0]):
            color = COLORS[number - 1] / COLORS[number - 1].sum()
            assert (np.abs(shares - color).max(axis=1) < 0.02).mean() > 0.002
        drawn = scene_picture(scene, PANDA, view)
        for flag, color in ((True, HELD), (False, FAILED)):
            seen = (drawn == np.array(color)).all(axis=2).any()
            assert seen == (scene.grasps["success"] == flag).any()

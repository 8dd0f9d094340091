"""Searches for failures that take seconds, and detectors for them."""

import numpy as np

from egad.config import Settings
from egad.config.stages import DetectorFailures, select
from egad.detectors import Grasp
from egad.objects import load

FEW = {
    "attempts": 30,
    "engines": ["mujoco"],
    "screen": 1,
    "choose": 2,
    "confirm": 4,
    "explain": 1,
    "least_reference": 0.5,
    "least_regret": 0.2,
    "confidence": 0.3,
}
QUICK = {
    "bundle": {"max_parts": 8, "deviation": 0.004},
    "grasp_label": {"grasps": 20},
    "robust": {"samples": 5},
    "similarity": {"vertices": 1000, "base_count": 20},
}


def settings_of(detector="random", **changes):
    """Settings of a small search with the panda, and others of its section."""
    shape = load().shape.model_dump(mode="json")
    whole = {
        "failures": FEW | changes,
        "shape": shape,
        "detectors": {"own": {"detector": detector}},
        **QUICK,
    }
    return select(Settings.model_validate(whole), DetectorFailures, "panda", "own")


class Aside:
    """A detector of one grasp beside the object; it may end the program at some attempt."""

    def __init__(self, last=None):
        self.asked, self.last = 0, last

    def __call__(self, _view, gripper, rng):
        if self.asked == self.last:
            raise KeyboardInterrupt
        self.asked += 1
        return [Grasp((0.1, 0.1, 0.03), float(rng.uniform(0, np.pi)), gripper.opening, 0.0, 1.0)]


def failing(_view, _gripper, _rng):
    """A detector that does nothing but fail."""
    return 1 / 0

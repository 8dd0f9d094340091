"""Searches for failures that take seconds: coarse objects, and detectors for them."""

from contextlib import contextmanager
from functools import cache

import numpy as np
import pandas as pd
import pytest

from egad.bench.failures import DetectorFailures
from egad.detectors import Grasp
from egad.evolution import UNBOUND, evolution_parameters, express
from egad.objects import dataset_of, load
from egad.tables.evolution import GENOME
from egad_workflow.settings import Settings, select

SHAPE = load().shape.model_copy(update={"resolution": 10})
FEW = {
    "attempts": 32,
    "engines": ["mujoco"],
    "screen": 1,
    "choose": 1,
    "confirm": 4,
    "explain": 1,
    "least_reference": 0.5,
    "least_difference": 0.2,
    "confidence": 0.3,
}
QUICK = {
    "bundle": {"max_parts": 2, "deviation": 0.01, "volume_error": 0.5},
    "print_check": {"wall": 0.003, "blunting": 0.01},
    "grasp_label": {"grasps": 20},
    "robust": {"samples": 5},
    "similarity": {"vertices": 1000, "base_count": 20},
    "shape": SHAPE.model_dump(mode="json"),
}


@contextmanager
def parts_kept(folder):
    """Let convex parts be made once, and be kept in a folder, for as long as the block lasts."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setenv("EGAD_CACHE_DIR", str(folder))
        yield


@cache
def coarse_objects():
    """The released objects of which something is left in coarse voxels, with their old measures."""
    breeding = evolution_parameters(0).model_copy(update={"shape": SHAPE})
    rows = []
    for row in load().archive.to_dict("records"):
        solid = express({name: row[name] for name in GENOME.names}, breeding, UNBOUND)
        if not isinstance(solid, str):
            rows.append(row | {"id": solid.id, "voxels": solid.packed})
    return dataset_of(pd.DataFrame(rows).drop_duplicates("id", ignore_index=True), SHAPE)


def settings_of(detector="random", **changes):
    """Settings of a small search with the panda, and others of its section."""
    whole = {
        "failures": FEW | changes,
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

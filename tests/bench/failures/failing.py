"""An object, hands and detectors of which it is known where they fail."""

from importlib.util import find_spec

import numpy as np
import pytest
import trimesh

import egad
from egad.bench.failures import FailureSearch
from egad.bench.failures.finding import failure_parameters
from egad.detectors import Grasp
from egad.detectors.antipodal import antipodal_depth
from egad.evalset import PrintCheck
from egad.sim import FAST_ENGINES

PANDA = egad.gripper("panda")
CUBE = trimesh.creation.box((0.05, 0.05, 0.05))
USED = tuple(filter(find_spec, FAST_ENGINES))
EACH_FAST_ENGINE = pytest.mark.parametrize("engine", USED)
QUICK = {
    "screen": 2,
    "choose": 2,
    "confirm": 6,
    "explain": 3,
    "least_reference": 0.5,
    "least_difference": 0.3,
    "confidence": 0.6,
}


def beside(_view, gripper, _rng):
    """A detector that always closes beside the object."""
    return [Grasp((0.2, 0.2, 0.03), 0.0, gripper.opening, 0.02, 1.0)]


def nothing(_view, _gripper, _rng):
    """A detector that proposes nothing."""
    return []


def broken(_view, _gripper, _rng):
    """A detector with a bug."""
    raise ValueError("oops")


def both(view, gripper, rng):
    """A detector that prefers a grasp beside the object to one that holds."""
    good = antipodal_depth(view, gripper, rng)[:3]
    worse = [Grasp(each.center, each.angle, each.width, each.depth, 0.5) for each in good]
    return [*beside(view, gripper, rng), *worse]


def parameters(**search):
    """Settings of a quick search for failures from above."""
    found = FailureSearch(**{"approach": "above", "shards": 1, "engines": USED, **QUICK, **search})
    settings = failure_parameters(PANDA, found)
    return settings.model_copy(update={"print_check": PrintCheck(wall=0.003)})


def rng():
    """A generator that always gives the same."""
    return np.random.default_rng(0)

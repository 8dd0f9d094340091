"""Grasp detectors: their input, their answers, and how one is found by its name."""

import functools
import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from egad import plugins
from egad.detectors.antipodal import antipodal_depth
from egad.detectors.asking import Detector
from egad.detectors.base import WHERE, Answer, DetectorError, Grasp, poses_of
from egad.detectors.cloud import antipodal_cloud
from egad.detectors.ggcnn import GGCNN, check_ggcnn
from egad.detectors.graspgen import GraspGen
from egad.detectors.parameters import GRASPGEN, SHIPPED_NETWORKS, DetectorConfig, knows_scene
from egad.detectors.random_detector import random_grasp
from egad.detectors.suction import suction_cloud, suction_depth
from egad.detectors.vgn import Vgn
from egad.errors import UserError
from egad.grippers import Gripper

QUICK: dict[str, Detector] = {
    "antipodal-depth": antipodal_depth,
    "random": random_grasp,
    "suction-depth": suction_depth,
}
"""Detectors that need only the image, and no process of their own that can be stopped."""

IN_SCENES: dict[str, Detector] = {
    "antipodal-cloud": antipodal_cloud,
    "suction-cloud": suction_cloud,
    **QUICK,
}
"""The same for scenes of several objects, which many cameras see."""


def make_detector(config: DetectorConfig) -> Detector:
    """Make a detector, also from the user's own class or function; UserError if it cannot."""
    config = _with_shipped_weights(config)
    name = config.name
    if name in IN_SCENES:
        return IN_SCENES[name]
    if knows_scene(config):
        raise UserError(f"{name} knows where the object is, so it works in simulated trials only")
    if name == GRASPGEN and config.address:
        return GraspGen(config.address)
    if name == "ggcnn":
        return with_checked_answers(GGCNN(config.weights, config.execution))
    if name == "vgn":
        return with_checked_answers(Vgn(config.weights, config.threshold, config.avoid_collisions))
    return with_checked_answers(_own(config))


def with_checked_answers(detect: Callable[..., Any]) -> Detector:
    """The same detector, but with an error for an answer that is not grasps."""

    @functools.wraps(detect, updated=())
    def ask(seen: object, gripper: Gripper, rng: np.random.Generator, /) -> Answer:
        answer = detect(seen, gripper, rng)
        try:
            return _grasps_of(answer)
        except (TypeError, ValueError, AttributeError) as error:
            raise DetectorError(
                f"{_name_with_place(detect)} must return a list of grasps, or a tuple of poses, "
                f"widths and scores, but returned {type(answer).__name__} {answer!r:.200}: {error}"
            ) from error

    return ask


def _grasps_of(answer: Any) -> Answer:  # noqa: ANN401 (whatever it gives)
    """An answer as grasps from above, or as poses if it is a tuple of arrays."""
    if isinstance(answer, tuple) and answer and not any(hasattr(each, "center") for each in answer):
        return poses_of(answer)
    return [_plain(grasp) for grasp in answer]


def _name_with_place(detect: Callable[..., Any]) -> str:
    """A detector with the file and line of its code, if it is Python."""
    called = inspect.unwrap(detect if inspect.isroutine(detect) else type(detect).__call__)
    code = getattr(called, "__code__", None)
    name = getattr(detect, "__qualname__", type(detect).__name__)
    return f"{name} ({code.co_filename}, line {code.co_firstlineno})" if code else name


def _plain(grasp: Any) -> Grasp:  # noqa: ANN401 (whatever the user's code gives)
    """A grasp of plain numbers, from anything that has the numbers of a grasp."""
    x, y, z = (float(number) for number in grasp.center)
    numbers = (float(getattr(grasp, key)) for key in ("angle", "width", "depth", "quality"))
    return Grasp((x, y, z), *numbers)


def _own(config: DetectorConfig) -> Callable[..., Any]:
    found = plugins.find(config.name, WHERE, "class or function")
    if not isinstance(found, type):
        if config.weights:
            raise UserError(f"{WHERE}: {config.name} is not a class that takes `weights`")
        return found  # type: ignore[no-any-return]
    arguments = [config.weights] if config.weights else []
    try:
        made: Callable[..., Any] = found(*arguments)
    except Exception as error:
        message = f"{WHERE}: {config.name} cannot be made: {type(error).__name__}: {error}"
        raise UserError(message) from error
    if not callable(made):
        raise UserError(f"{WHERE}: {config.name} has no __call__(view, gripper, rng)")
    return made


def fingerprint(config: DetectorConfig) -> list[str]:
    """What decides the answers besides the library and the settings; UserError without a file."""
    config = _with_shipped_weights(config)
    if config.detector == "ggcnn":
        check_ggcnn(config.weights)
    if config.command:
        files = [word for word in config.command if Path(word).is_file()]
        return [plugins.file_hash(file, WHERE) for file in files]
    is_own = ":" in config.name and not config.known_grasps
    own = [plugins.source_hash(config.name, WHERE)] if is_own else []
    weights = [plugins.file_hash(config.weights, WHERE)] if config.weights else []
    return [*own, *weights]


def _with_shipped_weights(config: DetectorConfig) -> DetectorConfig:
    """A shipped network as the detector that loads its weights; any other detector as it is."""
    settings = SHIPPED_NETWORKS.get(config.detector or "")
    return DetectorConfig(**settings) if settings else config

"""Asking a detector: with what it wants to see, and whatever it does wrong."""

import inspect
import logging
from collections.abc import Callable
from typing import Any, TypeVar

from egad.detectors.base import DetectorTimeoutError, Grasp, best_grasp
from egad.detectors.poses import GraspPoses, PoseGrasp, best_pose, pose_of
from egad.errors import UserError, check_name
from egad.grippers import Gripper
from egad.outcomes import Outcome
from egad.perception import Observation, PointCloud, Tsdf, View

log = logging.getLogger(__name__)
T = TypeVar("T")
Seen = View | tuple[View, ...] | PointCloud | Tsdf | Observation

INPUTS = ("view", "views", "cloud", "tsdf", "observation")


def wanted_input(detect: Callable[..., Any]) -> str:
    """What a detector wants to see: one of `INPUTS`.

    Args:
        detect: Has an attribute `observes` that names it, or a first parameter of that name;
            otherwise it gets the view from above.

    Raises:
        UserError: The attribute is something else.
    """
    whole = inspect.unwrap(detect)
    declared = getattr(whole, "observes", None)
    if declared is not None:
        return check_name("input of detectors", declared, INPUTS)
    try:
        first = next(iter(inspect.signature(whole).parameters), "")
    except ValueError:  # of code that is not Python
        return INPUTS[0]
    return first if first in INPUTS else INPUTS[0]


def check_views_will_do(detect: Callable[..., Any]) -> None:
    """Raise UserError for a detector that asks for more than trials give."""
    if (name := wanted_input(detect)) != INPUTS[0]:
        raise UserError(
            f"in trials, a detector gets a view from above; this one asks for `{name}`, which "
            "`egad benchmark` and `egad.run_benchmark` give"
        )


def seen_by(detect: Callable[..., Any], observation: Observation) -> Seen:
    """The part of an observation that a detector wants."""
    name = wanted_input(detect)
    seen: Seen = observation if name == "observation" else getattr(observation, name)
    return seen


def choose(answer: list[Grasp] | GraspPoses, gripper: Gripper) -> PoseGrasp | Outcome:
    """The best grasp of an answer that the hand can do, as a pose; or why there is none."""
    if isinstance(answer, GraspPoses):
        return best_pose(answer, gripper)
    best = best_grasp(answer, gripper)
    return best if isinstance(best, Outcome) else pose_of(best, gripper)


def from_above(answer: list[Grasp] | GraspPoses) -> list[Grasp]:
    """An answer of grasps from above.

    Raises:
        TypeError: They are poses, which only a hand without an arm can carry out.
    """
    if isinstance(answer, GraspPoses):
        raise TypeError("it gives poses, not grasps from above: `egad benchmark` can try those")
    return answer


def try_to_plan(plan: Callable[[], T]) -> T | Outcome:
    """The result of asking a detector, or the outcome of the attempt if that goes wrong.

    Raises:
        UserError: The detector cannot be used at all.
        MemoryError: There is not enough.
    """
    try:
        return plan()
    except (UserError, MemoryError):
        raise
    except DetectorTimeoutError as error:
        log.warning("the detector was stopped: %s", error)
        return Outcome.TIMEOUT
    except Exception as error:
        log.warning("the detector failed: %s: %s", type(error).__name__, error)
        return Outcome.ERROR

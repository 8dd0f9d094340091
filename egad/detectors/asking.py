"""Asking a detector: what it wants to see, and the best of its answer."""

import inspect
from collections.abc import Callable
from typing import Any

from egad.detectors.base import DetectorError, Grasp, best_grasp
from egad.detectors.poses import GraspPoses, PoseGrasp, best_pose, pose_of
from egad.errors import UserError, check_name
from egad.grippers import Gripper
from egad.outcomes import Outcome
from egad.perception import Observation, PointCloud, Tsdf, View

Seen = View | tuple[View, ...] | PointCloud | Tsdf | Observation

INPUTS = ("view", "views", "cloud", "tsdf", "observation")


def wanted_input(detect: Callable[..., Any]) -> str:
    """What a detector wants to see: one of `INPUTS`.

    Args:
        detect: Has an attribute `observes` that names it, or a first parameter of that name. One
            whose first parameter says nothing gets the view from above: a name that begins with an
            underscore, or `*args`.

    Raises:
        UserError: The attribute or the parameter is something else.
    """
    whole = inspect.unwrap(detect)
    declared = getattr(whole, "observes", None)
    if declared is not None:
        return check_name("input of detectors", declared, INPUTS)
    try:
        first = next(iter(inspect.signature(whole).parameters.values()), None)
    except ValueError:  # of code that is not Python
        return INPUTS[0]
    if first is None or first.kind is first.VAR_POSITIONAL or first.name.startswith("_"):
        return INPUTS[0]
    if first.name not in INPUTS:
        raise UserError(
            f"the first parameter of a detector says what it gets, and {first.name!r} is none of "
            f"{', '.join(INPUTS)}; rename it, or set an attribute `observes`"
        )
    return first.name


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
        DetectorError: They are poses, which only a hand without an arm can carry out.
    """
    if isinstance(answer, GraspPoses):
        raise DetectorError("it gives poses, not grasps from above: `egad benchmark` tries those")
    return answer

"""Asking a detector: what it wants to see, and the best grasps of its answer."""

import inspect
import math
from collections.abc import Callable
from itertools import islice
from typing import Any

import numpy as np

from egad._util.arrays import Floats, Ints
from egad.detectors.base import DetectorError, Grasp, first_possible
from egad.detectors.camera import View
from egad.detectors.observation import Observation, PointCloud
from egad.detectors.poses import GraspPoses, PoseGrasp, best_pose, by_score, infeasibility, pose_of
from egad.detectors.tsdf import Tsdf
from egad.errors import UserError, check_name
from egad.grippers import Gripper
from egad.tables.outcomes import Outcome

Seen = View | tuple[View, ...] | PointCloud | tuple[PointCloud, ...] | Tsdf | Observation

INPUTS = ("view", "views", "cloud", "object_clouds", "tsdf", "observation")


def wanted_input(detect: Callable[..., Any]) -> str:
    """What a detector wants to see: one of `INPUTS`.

    Args:
        detect: A detector with an attribute `observes` that names its input, or a first parameter
            of that name. If the first parameter says nothing (its name begins with an underscore,
            or it is `*args`), the detector gets the view from above.

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
            f"the first parameter of a detector names its input, but {first.name!r} is none of "
            f"{', '.join(INPUTS)}; rename it, or set an attribute `observes`"
        )
    return first.name


def check_views_will_do(detect: Callable[..., Any]) -> None:
    """Raise UserError for a detector that asks for more than trials provide."""
    if (name := wanted_input(detect)) != INPUTS[0]:
        raise more_than_a_view("this one", f"`{name}`")


def more_than_a_view(who: str, what: str) -> UserError:
    """The error for a detector that asks for more than trials provide."""
    return UserError(
        f"in trials, a detector gets a view from above; {who} asks for {what}, which "
        "`egad benchmark` and `egad.run_benchmark` provide"
    )


def seen_by(detect: Callable[..., Any], observation: Observation) -> Seen:
    """The part of an observation that a detector wants."""
    name = wanted_input(detect)
    seen: Seen = observation if name == "observation" else getattr(observation, name)
    return seen


def choose(
    answer: list[Grasp] | GraspPoses,
    gripper: Gripper,
    threshold: float = -math.inf,
    shuffled: np.random.Generator | None = None,
) -> PoseGrasp | Outcome:
    """The grasp of an answer that is tried, as a pose; or why there is none.

    Args:
        answer: The answer of a detector.
        gripper: The hand, which must be able to execute it.
        threshold: Grasps of a lower score are left out.
        shuffled: Random number generator that picks any of the rest; None: the one of the highest
            score.
    """
    if isinstance(answer, GraspPoses):
        return best_pose(answer, gripper, _order(answer.scores, threshold, shuffled))
    order = _order(np.array([each.quality for each in answer]), threshold, shuffled)
    best = first_possible((answer[number] for number in order.tolist()), gripper)
    return best if isinstance(best, Outcome) else pose_of(best, gripper)


def ranked(
    answer: list[Grasp] | GraspPoses, gripper: Gripper, most: int
) -> list[PoseGrasp] | Outcome:
    """The grasps of an answer that the hand can execute, as poses, best first, at most `most`.

    If there is none, why, as for `best_pose`.
    """
    if not isinstance(answer, GraspPoses):
        chosen = [pose_of(each, gripper) for each in answer]
        answer = GraspPoses(
            np.array([each.pose for each in chosen]).reshape(-1, 4, 4),
            np.array([each.width for each in chosen]),
            np.array([each.score for each in chosen]),
        )
    first = best_pose(answer, gripper)
    if isinstance(first, Outcome):
        return first
    order = by_score(answer.scores).tolist()
    grasps = (
        PoseGrasp(answer.poses[i], float(answer.widths[i]), float(answer.scores[i])) for i in order
    )
    return list(islice((each for each in grasps if infeasibility(each, gripper) is None), most))


def _order(scores: Floats, threshold: float, shuffled: np.random.Generator | None) -> Ints:
    """Indices of the grasps that may be tried, in the order in which they are tried."""
    order = by_score(scores)
    order = order[~(scores[order] < threshold)]
    return order if shuffled is None else shuffled.permutation(order)


def from_above(answer: list[Grasp] | GraspPoses) -> list[Grasp]:
    """An answer of grasps from above; DetectorError if they are poses, which need a free hand."""
    if isinstance(answer, GraspPoses):
        raise DetectorError(
            "it returned poses, not grasps from above; `egad benchmark` can execute poses"
        )
    return answer

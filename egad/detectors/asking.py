"""Asking a detector: what it wants to see, and the best grasps of its answer."""

import inspect
import math
from collections.abc import Callable, Iterable, Iterator
from typing import Any, Protocol

import numpy as np

from egad.detectors.base import Answer, DetectorError, Grasp, GraspPoses
from egad.detectors.camera import View
from egad.detectors.observation import Observation, PointCloud
from egad.detectors.tsdf import Tsdf
from egad.errors import UserError, check_name
from egad.grippers import Gripper
from egad.tables.outcomes import Outcome

Seen = View | tuple[View, ...] | PointCloud | tuple[PointCloud, ...] | Tsdf | Observation

FAR = 0.4  # metres from the middle of the table: outside of any workspace
INPUTS = ("view", "views", "cloud", "object_clouds", "tsdf", "observation")


class Detector(Protocol):
    """Proposes grasps for what depth cameras see."""

    def __call__(
        self,
        seen: Any,  # noqa: ANN401 (what it asks for)
        gripper: Gripper,
        rng: np.random.Generator,
        /,
    ) -> Answer:
        """Propose grasps, in any order; none if there is nothing to hold.

        The answer may depend on these three alone, not on earlier calls: attempts are spread over
        processes, and each can be repeated by itself.

        Args:
            seen: A view from above, with intrinsics and pose of the camera, or whatever it asks for
                (`wanted_input`); the table is at height 0.
            gripper: The hand that will try.
            rng: The only source of randomness.
        """


def wanted_input(detect: Callable[..., Any]) -> str:
    """What a detector wants to see: one of `INPUTS`.

    Its attribute `observes` names it, or the name of its first parameter; if that says nothing (it
    begins with an underscore, or is `*args`), it gets the view from above. UserError for others.
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
    answer: Answer,
    gripper: Gripper,
    threshold: float = -math.inf,
    shuffled: np.random.Generator | None = None,
) -> Grasp | Outcome:
    """The best grasp above the threshold that the hand can execute, with its pose; or why none.

    DetectorError if all grasps are out of the workspace, as in the frame of a camera.
    """
    _check_frame(answer)
    best = _executable(_ordered(answer, threshold, shuffled), gripper, 1)
    return best if isinstance(best, Outcome) else best[0].as_pose(gripper)


def _check_frame(answer: Answer) -> None:
    if isinstance(answer, GraspPoses):
        places = answer.poses[:, :3, 3]
    else:
        places = np.array([each.center for each in answer])
    if len(places) and (np.linalg.norm(places, axis=1) > FAR).all():
        raise DetectorError(
            f"all {len(places)} grasps are more than {FAR} m from the middle of the table; are "
            "they in the frame of a camera, or not in metres? They must be in the world's"
        )


def best_grasp(grasps: list[Grasp], gripper: Gripper) -> Grasp | Outcome:
    """The first best grasp that the hand can execute; or `no_grasp`, or the flaw of the best."""
    best = _executable(_ordered(grasps), gripper, 1)
    return best if isinstance(best, Outcome) else best[0]


def ranked(answer: Answer, gripper: Gripper, most: int) -> list[Grasp] | Outcome:
    """The grasps that the hand can execute, with their poses, best first; or as `best_grasp`."""
    return _executable((each.as_pose(gripper) for each in _ordered(answer)), gripper, most)


def _ordered(
    answer: Answer, threshold: float = -math.inf, shuffled: np.random.Generator | None = None
) -> Iterator[Grasp]:
    """The grasps of an answer that may be tried, in the order in which they are tried."""
    if isinstance(answer, GraspPoses):
        scores = answer.scores
    else:
        scores = np.array([each.quality for each in answer])
    order = np.argsort(np.where(np.isfinite(scores), -scores, np.inf), kind="stable")
    order = order[~(scores[order] < threshold)]
    for number in (order if shuffled is None else shuffled.permutation(order)).tolist():
        if isinstance(answer, GraspPoses):
            pose, width = answer.poses[number], float(answer.widths[number])
            yield Grasp.of_pose(pose, width, float(scores[number]))
        else:
            yield answer[number]


def _executable(grasps: Iterable[Grasp], gripper: Gripper, most: int) -> list[Grasp] | Outcome:
    """The first grasps that the hand can execute; if there is none, why not the first."""
    kept: list[Grasp] = []
    reason = None
    for grasp in grasps:
        flaw = grasp.infeasibility(gripper)
        if flaw is None:
            kept.append(grasp)
        if len(kept) == most:
            break
        reason = reason or flaw
    return kept or reason or Outcome.NO_GRASP


def from_above(answer: Answer) -> list[Grasp]:
    """An answer of grasps from above; DetectorError if they are poses, which need a free hand."""
    if isinstance(answer, GraspPoses):
        raise DetectorError(
            "it returned poses, not grasps from above; `egad benchmark` can execute poses"
        )
    return answer

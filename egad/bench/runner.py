"""Grasps tried on a table: what a trial of one object and a clearing of several have in common."""

import math
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from egad.bench.cell_errors import EXACT, Deviation
from egad.bench.protocols import ClutterProtocol
from egad.bench.scenes import EGAD, RestingObject
from egad.detectors import (
    Answer,
    Detector,
    Failure,
    Grasp,
    Observation,
    View,
    choose,
    from_above,
    seen_by,
    try_to_plan,
)
from egad.grippers import Gripper
from egad.sim import Execution, Pose, World
from egad.tables.outcomes import Outcome

Generator = np.random.Generator
Proposal: TypeAlias = Grasp | Outcome | Failure  # a grasp, or why there is none
Propose = Callable[[Observation, Sequence[RestingObject], Generator], Proposal]


class InitialPose(NamedTuple):
    """The object at rest in `pose`, from which it falls; `kind`: dropped, from_hand or left."""

    kind: str
    pose: Pose


@dataclass(frozen=True)
class Attempt:
    """The result of an attempt."""

    # as in `Execution`, or one of `egad.tables.outcomes.POSE_FAILURES`; None if it was repeated
    # without a grasp, as it is not known why there was none
    outcome: Outcome | None
    # the objects on the table before it, and where they lay; none if they never did
    present: tuple[RestingObject, ...] = ()
    grasp: Grasp | None = None  # the grasp that was tried, if any
    # how far before the grasp a contact stopped the hand, metres; 0 if none did
    stopped: float = 0.0
    failure: str = ""  # what the detector did wrong, if it failed
    # number of the object that was held and removed, when a table is cleared
    held: int | None = None
    # where the object of a trial fell from; None if it never came to rest
    start: InitialPose | None = None
    lifted: float = 0.0  # height that the center of mass of the object of a trial gained, metres
    end: Pose | None = None  # its final pose; None if the simulation broke down

    @property
    def rest(self) -> Pose | None:
        """Where the object of a trial lay when the camera image was taken."""
        return self.present[0].pose if self.present else None

    def columns(self) -> dict[str, Any]:
        """What tables of trials and of cleared tables both say about it."""
        return {
            "success": self.outcome == Outcome.SUCCESS,
            "outcome": self.outcome.value if self.outcome else "",
            "stopped": self.stopped,
            "failure": self.failure,
        }


class Runner(ABC):
    """A table in a simulated world, with cameras and a hand."""

    def __init__(self, world: World, gripper: Gripper) -> None:
        """Set up in a running simulation of the gripper's robot."""
        self.world, self.gripper = world, gripper

    def vary(self, deviation: Deviation) -> None:
        """Let mass and friction deviate from now on."""
        self.world.mass_factor = deviation.mass
        self.world.friction_factor = deviation.friction

    def try_proposal(
        self, proposal: Proposal, present: Sequence[RestingObject], deviation: Deviation = EXACT
    ) -> Attempt:
        """Try a grasp of objects at rest, if there is one."""
        if isinstance(proposal, Failure):
            return Attempt(proposal.outcome, tuple(present), failure=proposal.text)
        if isinstance(proposal, Outcome):
            return Attempt(proposal, tuple(present))
        self.vary(deviation)
        done = self._execute(proposal, present, deviation)
        return Attempt(
            done.outcome,
            tuple(present),
            proposal,
            done.stopped,
            held=done.held,
            lifted=done.lifted,
            end=done.end,
        )

    def ask(self, detect: Detector, rest: Pose, rng: Generator) -> Answer:
        """The answer of a detector for one object at rest; it may raise any error."""
        camera_rng, detector_rng = rng.spawn(2)
        seen = self.see(rest, camera_rng)
        if isinstance(seen, View):
            return from_above(detect(seen, self.gripper, detector_rng))
        return detect(seen_by(detect, seen), self.gripper, detector_rng)

    @abstractmethod
    def drop(self, rng: Generator) -> Pose | None:
        """Drop one object; where it lies, or None if never still where the cameras see it."""

    @abstractmethod
    def see(self, rest: Pose, rng: Generator) -> View | Observation:
        """What the cameras see of one object at rest."""

    @abstractmethod
    def carry_out(self, rest: Pose, grasp: Grasp) -> Attempt:
        """Try a grasp of one object that lies still, in a world that is reset first."""

    @abstractmethod
    def _execute(
        self, grasp: Grasp, present: Sequence[RestingObject], deviation: Deviation
    ) -> Execution:
        """Execute a grasp, which deviates from the plan."""


def proposed_by(detect: Detector, gripper: Gripper, protocol: ClutterProtocol = EGAD) -> Propose:
    """A proposer that shows a detector its input and tries the grasp that the protocol says."""
    least = -math.inf if protocol.threshold is None else protocol.threshold

    def propose(observation: Observation, _: Sequence[RestingObject], rng: Generator) -> Proposal:
        order = rng.spawn(1)[0] if protocol.choice == "random" else None
        return try_to_plan(
            lambda: choose(
                detect(seen_by(detect, observation), gripper, rng), gripper, least, order
            )
        )

    return propose


def timed(propose: Propose, seconds: list[float]) -> Propose:
    """The same, but record how long each proposal took, from the depth images to the grasp."""

    def ask(observation: Observation, present: Sequence[RestingObject], rng: Generator) -> Proposal:
        begin = time.perf_counter()
        grasp = propose(observation, present, rng)
        seconds.append(time.perf_counter() - begin)
        return grasp

    return ask

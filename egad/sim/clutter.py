"""Rounds of clearing a table, one object after the other (Breyer et al. 2020, section V)."""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from egad._util.arrays import Floats
from egad.detectors import Detector, Failure, PoseGrasp, choose, seen_by, try_to_plan
from egad.grippers import Gripper
from egad.outcomes import Outcome
from egad.perception import (
    DepthCamera,
    Intrinsics,
    NoiseName,
    Observation,
    SceneKind,
    View,
    add_noise,
    camera_above,
    cameras_around,
    render_scene,
)
from egad.random import entropy, generator
from egad.sim.cell_errors import EXACT, Deviation, draw
from egad.sim.free_hand import execute_pose
from egad.sim.gripper import Fingers
from egad.sim.parameters import COLLISION_FORCE, Clutter
from egad.sim.scenes import WORKSPACE, RestingObject, make_scene, put, settle_from
from egad.sim.world import UnstableError, World

Generator = np.random.Generator
Proposal: TypeAlias = PoseGrasp | Outcome | Failure
Propose = Callable[[Observation, Sequence[RestingObject], Generator], Proposal]

CAMERA_DISTANCE = 2 * WORKSPACE
CAMERA_TILT = np.radians(30)
LOOKING_AT = np.array([0.0, 0.0, -0.05])  # the middle of the bottom of VGN's cube
CAMERA = Intrinsics(320, 240, 120 / np.tan(1.047 / 2), (159.5, 119.5))
OVERHEAD = Intrinsics.spanning(640, 480, 75.0)
OVERHEAD_HEIGHT = 0.6
FAILURES = 2  # in a row end a round


@dataclass(frozen=True)
class ClutterAttempt:
    """What came of an attempt.

    Attributes:
        outcome: As of `PoseExecution`, or one of `egad.outcomes.POSE_FAILURES`.
        present: The objects on the table before it.
        grasp: What was tried, if it came to that.
        held: Number of the object that was held.
        stopped: How far before the grasp something stopped the hand, metres.
        failure: What the detector did wrong, if it failed.
    """

    outcome: Outcome
    present: tuple[RestingObject, ...]
    grasp: PoseGrasp | None = None
    held: int | None = None
    stopped: float = 0.0
    failure: str = ""


class ClutterRunner:
    """A table with objects, cameras all around and a hand, to clear it."""

    def __init__(self, world: World, settings: Clutter) -> None:
        """Set up.

        Args:
            world: A running simulation of the objects of a round, with walls for a pile, and the
                robot `egad.sim.robot.free_hand`.
            settings: Cameras, and errors of the cell.
        """
        self.world = world
        self._errors = settings.errors
        self._gripper = Fingers(world).gripper
        self._rendered = [DepthCamera(model.mesh) for model in world.models]
        self._cameras = cameras_around(LOOKING_AT, settings.views, CAMERA_DISTANCE, CAMERA_TILT)

    def clear(
        self, propose: Propose, kind: SceneKind, noise: NoiseName, seed: int
    ) -> Iterator[ClutterAttempt]:
        """Grasp one object after the other, until none is left or nothing works any more.

        A round ends after two failures in a row, when nothing is proposed, or when the simulation
        goes wrong. All depends on the arguments alone; the scene at the beginning on kind and seed.

        Args:
            propose: What decides on the grasps.
            kind: How the objects lie.
            noise: What goes wrong in depth images.
            seed: For the scene and, apart from it, for detector and cameras.
        """
        try:
            present = self.begin(kind, seed)
        except UnstableError:
            yield ClutterAttempt(Outcome.FAILED, ())
            return

        def ask(number: int, present: Sequence[RestingObject]) -> Proposal:
            view = self.observe(present, noise, generator(seed, "cameras", number))
            return propose(view, present, generator(seed, "detector", number))

        yield from self._attempts(ask, present, seed)

    def _attempts(
        self,
        ask: Callable[[int, Sequence[RestingObject]], Proposal],
        present: Sequence[RestingObject],
        seed: int,
    ) -> Iterator[ClutterAttempt]:
        """The attempts of a round that began: `ask` gives the grasp of each by its number."""
        number = failures = 0
        while present and failures < FAILURES:
            grasp = ask(number, present)
            attempt, present = self.carry_out(grasp, present, self._deviation(seed, number))
            yield attempt
            failures = 0 if attempt.outcome == Outcome.SUCCESS else failures + 1
            number += 1
            if attempt.outcome in (Outcome.NO_GRASP, Outcome.FAILED):
                return

    def begin(self, kind: SceneKind, seed: int) -> list[RestingObject]:
        """Put the objects on the table.

        Raises:
            UnstableError: The simulation went wrong.
        """
        return make_scene(self.world, kind, generator(seed, "scene", kind))

    def repeat(
        self, grasps: Sequence[PoseGrasp | Outcome], kind: SceneKind, seed: int
    ) -> Iterator[ClutterAttempt]:
        """A round that began, again without its detector: the same, bit by bit.

        It ends as a round does, not with the last grasp: then no more are proposed.

        Args:
            grasps: What was tried in each attempt, or why nothing was.
            kind: How the objects lie.
            seed: That of the round.
        """
        known = dict(enumerate(grasps))
        present = self.begin(kind, seed)
        yield from self._attempts(
            lambda number, _: known.get(number, Outcome.NO_GRASP), present, seed
        )

    def observe(
        self, present: Sequence[RestingObject], noise: NoiseName, rng: Generator
    ) -> Observation:
        """What the cameras see of objects at rest."""
        rendered = [self._rendered[each.number] for each in present]
        matrices = [each.pose.matrix for each in present]

        def seen(intrinsics: Intrinsics, pose: Floats) -> View:
            return add_noise(noise, render_scene(rendered, matrices, intrinsics, pose), rng)

        views = tuple(seen(CAMERA, pose) for pose in self._cameras)
        return Observation(seen(OVERHEAD, camera_above(OVERHEAD_HEIGHT)), views, WORKSPACE)

    def _deviation(self, seed: int, number: int) -> Deviation:
        """What is off in an attempt; the camera is calibrated once a round."""
        return draw(self._errors, seed, entropy(seed, "attempt", number))

    def carry_out(
        self,
        grasp: Proposal,
        present: Sequence[RestingObject],
        deviation: Deviation = EXACT,
    ) -> tuple[ClutterAttempt, list[RestingObject]]:
        """Try a grasp, if there is one; what came of it, and what is left when all lies still.

        If the simulation goes wrong while things settle, nothing is left to go on with.
        """
        if isinstance(grasp, Failure):
            failed = ClutterAttempt(grasp.outcome, tuple(present), failure=grasp.text)
            return failed, list(present)
        if isinstance(grasp, Outcome):
            return ClutterAttempt(grasp, tuple(present)), list(present)
        self.world.mass_factor, self.world.friction_factor = deviation.mass, deviation.friction
        put(self.world, present)
        done = deviation.pose(grasp, self._gripper)
        limit = COLLISION_FORCE * deviation.stopping_force
        result = execute_pose(self.world, done.pose, done.width, limit)
        attempt = ClutterAttempt(result.outcome, tuple(present), grasp, result.held, result.stopped)
        try:
            numbers = [each.number for each in present if each.number != result.held]
            moved = [RestingObject(number, self.world.pose(number)) for number in numbers]
            return attempt, settle_from(self.world, moved)
        except UnstableError:
            return attempt, []


def proposed_by(detect: Detector, gripper: Gripper) -> Propose:
    """A detector that sees what it wants of the scene, and whose best grasp is tried."""

    def propose(observation: Observation, _: Sequence[RestingObject], rng: Generator) -> Proposal:
        return try_to_plan(
            lambda: choose(detect(seen_by(detect, observation), gripper, rng), gripper)
        )

    return propose


def timed(propose: Propose, seconds: list[float]) -> Propose:
    """The same, but it notes how long each answer took, from the depth images to the grasp."""

    def ask(observation: Observation, present: Sequence[RestingObject], rng: Generator) -> Proposal:
        begin = time.perf_counter()
        grasp = propose(observation, present, rng)
        seconds.append(time.perf_counter() - begin)
        return grasp

    return ask

"""Rounds of clearing a table, one object after the other (Breyer et al. 2020, section V)."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np
from typing_extensions import override

from egad._util.arrays import Floats
from egad.bench.cell_errors import EXACT, Deviation, draw
from egad.bench.parameters import Clutter
from egad.bench.protocols import SceneCameras, SceneKind
from egad.bench.runner import Attempt, Generator, Proposal, Propose, Runner
from egad.bench.scenes import WORKSPACE, RestingObject, make_scene, put, settle_from
from egad.detectors import (
    DepthCamera,
    Grasp,
    Intrinsics,
    NoiseName,
    Observation,
    View,
    add_noise,
    camera_above,
    cameras_around,
    render_scene,
)
from egad.random import entropy, generator
from egad.sim import ContactRules, Execution, Fingers, Pose, UnstableError, World, execute_pose
from egad.tables.outcomes import Outcome

OVERHEAD = Intrinsics.spanning(640, 480, 75.0)
OVERHEAD_HEIGHT = 0.6
POINT_SIGMA = 0.0008  # metres, of the noise `points`


class ClearingRunner(Runner):
    """A table with objects, cameras all around it and a hand without an arm that clears it."""

    def __init__(self, world: World, settings: Clutter) -> None:
        """Set up; for a pile, the world has walls, and its robot is `egad.sim.robots.free_hand`."""
        super().__init__(world, Fingers(world).gripper)
        self._errors = settings.errors
        self._protocol = settings.protocol
        self._noise = settings.noises[0]
        self._rendered = [DepthCamera(model.mesh) for model in world.models]

    @override
    def drop(self, rng: Generator) -> Pose | None:
        try:
            return make_scene(self.world, "single", rng, self._protocol)[0].pose
        except UnstableError:
            return None

    @override
    def see(self, rest: Pose, rng: Generator) -> Observation:
        cameras = camera_poses(self._protocol.cameras, rng)
        return self.observe([RestingObject(0, rest)], self._noise, cameras, rng)

    @override
    def carry_out(self, rest: Pose, grasp: Grasp) -> Attempt:
        return self.try_proposal(grasp, [RestingObject(0, rest)])

    def clear(
        self, propose: Propose, kind: SceneKind, noise: NoiseName, seed: int
    ) -> Iterator[Attempt]:
        """Grasp one object after the other until none is left or the protocol ends it."""
        try:
            present = self.begin(kind, seed)
        except UnstableError:
            yield Attempt(Outcome.FAILED, ())
            return

        def ask(number: int, present: Sequence[RestingObject]) -> Proposal:
            poses = camera_poses(self._protocol.cameras, generator(seed, "views", number))
            view = self.observe(present, noise, poses, generator(seed, "cameras", number))
            return propose(view, present, generator(seed, "detector", number))

        yield from self._attempts(ask, present, seed)

    def _attempts(
        self,
        ask: Callable[[int, Sequence[RestingObject]], Proposal],
        present: Sequence[RestingObject],
        seed: int,
    ) -> Iterator[Attempt]:
        """The attempts of a round that began: `ask` returns the grasp for each number."""
        number = failures = skips = 0
        while present and failures < self._protocol.failures and skips < self._protocol.skips:
            grasp = ask(number, present)
            attempt, present = self.clear_one(grasp, present, self._deviation(seed, number))
            yield attempt
            number += 1
            if attempt.outcome == Outcome.FAILED:
                return
            if attempt.outcome == Outcome.NO_GRASP:
                skips += 1
            else:
                failures = 0 if attempt.outcome == Outcome.SUCCESS else failures + 1

    def begin(self, kind: SceneKind, seed: int) -> list[RestingObject]:
        """Put the objects on the table; UnstableError if the simulation goes wrong."""
        return make_scene(self.world, kind, generator(seed, "scene", kind), self._protocol)

    def repeat(
        self, grasps: Sequence[Grasp | Outcome], kind: SceneKind, seed: int
    ) -> Iterator[Attempt]:
        """Repeat a round bit by bit from its grasps, or why there was none; no detector."""
        known = dict(enumerate(grasps))
        present = self.begin(kind, seed)
        yield from self._attempts(
            lambda number, _: known.get(number, Outcome.NO_GRASP), present, seed
        )

    def observe(
        self,
        present: Sequence[RestingObject],
        noise: NoiseName,
        poses: Sequence[Floats],
        rng: Generator,
    ) -> Observation:
        """What the cameras see of objects at rest, from the given poses and from above."""
        rendered = [self._rendered[each.number] for each in present]
        matrices = [each.pose.matrix for each in present]

        def seen(intrinsics: Intrinsics, pose: Floats) -> View:
            return add_noise(noise, render_scene(rendered, matrices, intrinsics, pose), rng)

        intrinsics = intrinsics_of(self._protocol.cameras)
        views = tuple(seen(intrinsics, pose) for pose in poses)
        above = seen(OVERHEAD, camera_above(OVERHEAD_HEIGHT))
        if noise != "points":
            return Observation(above, views, WORKSPACE)
        return Observation(above, views, WORKSPACE, POINT_SIGMA, int(rng.integers(2**63)))

    def _deviation(self, seed: int, number: int) -> Deviation:
        """The deviation of an attempt; the camera is calibrated once per round."""
        return draw(self._errors, seed, entropy(seed, "attempt", number))

    def clear_one(
        self, proposal: Proposal, present: Sequence[RestingObject], deviation: Deviation = EXACT
    ) -> tuple[Attempt, list[RestingObject]]:
        """Try a grasp, if any; the result, and objects at rest, none if simulation broke."""
        attempt = self.try_proposal(proposal, present, deviation)
        if attempt.grasp is None:
            return attempt, list(present)
        try:
            numbers = [each.number for each in present if each.number != attempt.held]
            moved = [RestingObject(number, self.world.pose(number)) for number in numbers]
            return attempt, settle_from(self.world, moved)
        except UnstableError:
            return attempt, []

    @override
    def _execute(
        self, grasp: Grasp, present: Sequence[RestingObject], deviation: Deviation
    ) -> Execution:
        put(self.world, present)
        rules = self._protocol
        if rules.opening == "full":
            grasp = replace(grasp, width=self.gripper.opening)
        done = deviation.apply(grasp, self.gripper)
        contacts = ContactRules(
            rules.contact,
            rules.stopping_force * deviation.stopping_force,
            rules.success == "pinched",
            rules.removed == "first",
        )
        return execute_pose(self.world, done.pose, done.width, contacts)


def camera_poses(cameras: SceneCameras, rng: Generator) -> list[Floats]:
    """Where the cameras around a table are, (4, 4) each; all have the same distance and tilt."""
    ranges = (cameras.distance, cameras.tilt, cameras.azimuth)
    shares = rng.uniform(size=len(ranges)).tolist()
    distance, tilt, azimuth = (
        low + share * (high - low) for (low, high), share in zip(ranges, shares, strict=True)
    )
    target = np.array([0.0, 0.0, cameras.aim])
    return cameras_around(
        target, cameras.views, distance, float(np.radians(tilt)), float(np.radians(azimuth))
    )


def intrinsics_of(cameras: SceneCameras) -> Intrinsics:
    """Intrinsics of each camera around a table."""
    width, height = cameras.image
    focal = np.float64(cameras.focal)  # keeps the noise in double precision
    return Intrinsics(width, height, focal, ((width - 1) / 2, (height - 1) / 2))

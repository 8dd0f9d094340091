"""One grasp trial: drop the object, take an image, plan, and carry out the grasp."""

import logging
import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import trimesh
from scipy.spatial.transform import Rotation
from typing_extensions import override

from egad._util.arrays import Floats
from egad.bench.cell_errors import EXACT, Deviation
from egad.bench.parameters import TrialProtocol
from egad.bench.runner import Attempt, InitialPose, Proposal, Runner
from egad.bench.scenes import RestingObject, settle
from egad.detectors import (
    DepthCamera,
    Detector,
    Grasp,
    ImageNoise,
    Intrinsics,
    Labels,
    View,
    add_sensor_noise,
    best_grasp,
    camera_above,
    from_above,
    try_to_plan,
)
from egad.sim import Arm, ContactRules, Execution, Pose, UnstableError, World, moved
from egad.sim.execution import execute
from egad.tables.outcomes import Outcome

log = logging.getLogger(__name__)

SETTLING_TIME = 4.0  # seconds, at most
REST_SPEED = 0.003  # m/s
REST_TURNING = 0.05  # rad/s
DROP_HEIGHT = 0.1  # metres: of the lowest point of the object above the table
DROP_SPREAD = 0.03  # the center of mass is dropped at most this far from the middle, both ways
DROPS = 5
# Released upright, nearly all objects lie as before, and the same grasp works 20 times.
TILT = np.pi / 2
WORKSPACE = 0.12  # metres: objects further than this from the middle are dropped again
MOVED = 0.01  # metres; if no point moved further, a detector would try the same again
UNSURE = 1e-3  # metres: by how much a shift may differ with other arithmetic


def initial_poses(
    mesh: trimesh.Trimesh, left: InitialPose | None, rng: np.random.Generator
) -> Iterator[InitialPose]:
    """Initial poses to try in turn: dropped, or as the last attempt left it."""
    if left is not None and left.kind == "from_hand":
        turned = _tilted(left.pose.quaternion, rng)
        yield InitialPose("from_hand", _above(mesh, turned, rng))
    elif left is not None:
        yield left
    for _ in range(DROPS):
        quaternion = rng.normal(size=4)
        quaternion /= np.sqrt((quaternion**2).sum())  # BLAS has a norm for each processor
        yield InitialPose("dropped", _above(mesh, quaternion, rng))


def generators(seed: int) -> list[np.random.Generator]:
    """The random numbers of an attempt: of its drops, its detector and its camera."""
    return np.random.default_rng(seed).spawn(3)


def largest_shift(mesh: trimesh.Trimesh, before: Pose, after: Pose) -> float:
    """How far the point of an object that moved furthest moved, metres."""
    shifts = moved(mesh.vertices, after.matrix - before.matrix)
    return float(np.linalg.norm(shifts, axis=1).max())


def _above(mesh: trimesh.Trimesh, quaternion: Floats, rng: np.random.Generator) -> Pose:
    """A pose above the middle of the table, within `DROP_SPREAD`."""
    x, y = rng.uniform(-DROP_SPREAD, DROP_SPREAD, size=2)
    turned = moved(mesh.vertices, Pose(np.zeros(3), quaternion).matrix)
    return Pose(np.array([x, y, DROP_HEIGHT - turned[:, 2].min()]), quaternion)


def _tilted(quaternion: Floats, rng: np.random.Generator) -> Floats:
    """Tilt a quaternion (x, y, z, w) any way by at most `TILT`, and turn it about the vertical."""
    turn, way = rng.uniform(-np.pi, np.pi, size=2)
    axis = np.array([math.cos(way), math.sin(way), 0.0])
    tilt = Rotation.from_rotvec(axis * rng.uniform(0, TILT))
    tilted: Floats = (
        Rotation.from_euler("z", turn) * tilt * Rotation.from_quat(quaternion)
    ).as_quat()
    return tilted


class Ready(NamedTuple):
    """An object that lies still in the workspace."""

    start: InitialPose  # where it fell from
    rest: Pose


class TrialRunner(Runner):
    """A table with an object, a camera above it and a hand on an arm."""

    def __init__(self, world: World, arm: Arm, trials: TrialProtocol) -> None:
        """Set up in a running simulation of the arm's robot."""
        super().__init__(world, arm.robot.gripper)
        self.arm, self.trials = arm, trials
        self._camera = DepthCamera(world.model.mesh)
        self.intrinsics = Intrinsics.spanning(*trials.image, trials.field_of_view)
        self.camera_pose = camera_above(trials.camera_height)

    def attempt(
        self,
        detect: Detector | Labels,
        seed: int,
        before: Attempt | None = None,
        deviation: Deviation = EXACT,
    ) -> Attempt:
        """Make one attempt, from drop to hold; the seed alone determines all random numbers."""
        self.vary(deviation)
        drop_rng, detector_rng, camera_rng = generators(seed)
        ready = self.begin(drop_rng, before)
        if ready is None:
            return Attempt(Outcome.FAILED)
        proposal = self._plan(detect, self.noisy_view(camera_rng), detector_rng)
        return self._finish(proposal, ready, deviation)

    def repeat(
        self, start: InitialPose, grasp: Grasp | None, deviation: Deviation = EXACT
    ) -> Attempt:
        """Repeat an attempt bit by bit from its initial pose and grasp, without its detector."""
        self.vary(deviation)
        rest = self._settled(start)
        if rest is None:
            return Attempt(Outcome.FAILED)
        if grasp is None:
            return Attempt(None, (RestingObject(0, rest),), start=start, end=rest)
        return self._finish(grasp, Ready(start, rest), deviation)

    @override
    def drop(self, rng: np.random.Generator) -> Pose | None:
        ready = self.begin(rng)
        return None if ready is None else ready.rest

    @override
    def see(self, rest: Pose, rng: np.random.Generator) -> View:
        self.place(rest)
        return self.noisy_view(rng)

    def place(self, rest: Pose) -> None:
        """Place the object at rest in a world that is reset."""
        self.world.reset()
        self.world.place(rest)

    @override
    def carry_out(self, rest: Pose, grasp: Grasp) -> Attempt:
        self.place(rest)
        return self._finish(grasp, Ready(InitialPose("left", rest), rest), EXACT)

    def render_view(self) -> View:
        """A depth image of the object at its current pose."""
        return self._camera.render(self.world.pose().matrix, self.intrinsics, self.camera_pose)

    def noisy_view(self, rng: np.random.Generator) -> View:
        """The same as the camera of the trials sees it, with its noise."""
        view = self.render_view()
        if self.trials.depth_noise == 0:
            return view
        return add_sensor_noise(
            view, ImageNoise(disparity=self.trials.depth_noise, holes=True), rng
        )

    def _finish(self, proposal: Proposal, ready: Ready, deviation: Deviation) -> Attempt:
        """An attempt at an object that lies still."""
        attempt = self.try_proposal(proposal, [RestingObject(0, ready.rest)], deviation)
        end = ready.rest if attempt.grasp is None else attempt.end
        return replace(attempt, start=ready.start, end=end)

    @override
    def _execute(
        self, grasp: Grasp, present: Sequence[RestingObject], deviation: Deviation
    ) -> Execution:
        force = self.trials.stopping_force * deviation.stopping_force
        return execute(
            self.world,
            self.arm,
            self.trials,
            deviation.apply(grasp, self.gripper),
            rules=ContactRules(self.trials.contact, force),
        )

    def _plan(self, detect: Detector | Labels, view: View, rng: np.random.Generator) -> Proposal:
        """The grasp to try, or the outcome if there is none; errors of the detector are caught."""
        place = self.world.pose().matrix @ self.world.model.to_principal

        def plan() -> Grasp | Outcome:
            if isinstance(detect, Labels):
                grasps = detect.propose(place, view, self.gripper)
            else:
                grasps = from_above(detect(view, self.gripper, rng))
            return best_grasp(grasps, self.gripper)

        return try_to_plan(plan)

    def begin(self, rng: np.random.Generator, before: Attempt | None = None) -> Ready | None:
        """Drop the object, or leave it, until it lies still in the workspace; None if never."""
        for start in self.initial_poses(rng, before):
            rest = self.rest_from(start)
            if rest is not None:
                return Ready(start, rest)
        return None

    def initial_poses(
        self, rng: np.random.Generator, before: Attempt | None
    ) -> Iterator[InitialPose]:
        """Initial poses to try in turn after an attempt."""
        left = None if self.trials.reset == "redrop" or before is None else self._left_by(before)
        return initial_poses(self.world.model.mesh, left, rng)

    def rest_from(self, start: InitialPose) -> Pose | None:
        """Where the object comes to rest in the workspace; None if it does not."""
        rest = self._settled(start)
        return rest if rest is not None and self._in_workspace(rest) else None

    def _left_by(self, before: Attempt) -> InitialPose | None:
        """Where an attempt left the object; None if it did not move or simulation broke."""
        if before.end is None or before.rest is None:
            return None
        if before.outcome == Outcome.SUCCESS:
            return InitialPose("from_hand", before.end)
        shift = largest_shift(self.world.model.mesh, before.rest, before.end)
        return InitialPose("left", before.end) if shift > MOVED else None

    def barely_moved(self, before: Attempt) -> bool:
        """Whether rounding could decide if an attempt moved the object."""
        if before.outcome == Outcome.SUCCESS or before.end is None or before.rest is None:
            return False
        shift = largest_shift(self.world.model.mesh, before.rest, before.end)
        return abs(shift - MOVED) < UNSURE

    def _settled(self, start: InitialPose) -> Pose | None:
        """Let the object fall in an empty world until it lies still; None if it never does."""
        self.world.reset()
        self.world.place(start.pose)
        try:
            if settle(self.world, SETTLING_TIME, REST_SPEED, REST_TURNING):
                return self.world.pose()
        except UnstableError as error:
            log.warning("the object did not come to rest: %s", error)
        return None

    def _in_workspace(self, rest: Pose) -> bool:
        """Whether the object is near the middle, and the camera sees all of it."""
        if np.linalg.norm(rest.position[:2]) > WORKSPACE:
            return False
        seen = (self.world.vertices() - self.camera_pose[:3, 3]) @ self.camera_pose[:3, :3]
        return self.intrinsics.sees(seen)

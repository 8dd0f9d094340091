"""One object on a table and a hand without an arm: what it could try, and why it fails."""

from itertools import islice, zip_longest
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

from egad._util.arrays import Floats
from egad.bench.cell_errors import EXACT, Deviation
from egad.bench.clearing_runner import ClearingRunner
from egad.bench.failures.object_runner import MAX_PROPOSALS, ObjectRunner
from egad.bench.hands.parameters import HandTrials
from egad.bench.naive_grasps import sample_pose
from egad.bench.parameters import Clutter
from egad.bench.protocols import ClutterProtocol
from egad.bench.scene_labels import SceneLabels
from egad.bench.scenes import RestingObject
from egad.detectors import (
    IN_SCENES,
    Answer,
    Detector,
    Failure,
    Grasp,
    GraspPoses,
    in_collision,
    ranked,
    try_to_plan,
)
from egad.geometry import spread
from egad.grasps import FIXED_SIDE_CLEARANCE, expected_distance
from egad.grippers import JawBody, body_of
from egad.grippers.kinds import CupKind, JawKind
from egad.random import generator
from egad.sim import TIME_STEP, Pose, UnstableError, World, moved
from egad.tables.hands import OF_OUTCOME, SWING, Cause
from egad.tables.outcomes import Outcome

PROTOCOL = ClutterProtocol(contact="collided")
HOLD = 0.5  # seconds that an object is held up
SPACING = 0.004  # metres, between points of the surface that are tested for collisions
SAMPLED = 64  # naive grasps among which the search looks for free ones
USUAL = {JawKind.name: "antipodal-depth", CupKind.name: "suction-depth"}
"""The detector of each kind of gripper that needs no weights."""


class HandResult(NamedTuple):
    """What became of an attempt."""

    outcome: Outcome
    cause: Cause
    turned: float = np.nan  # degrees, if the object was held


class _Place(NamedTuple):
    """What is known about an object where it lies."""

    key: bytes  # of the pose of rest
    points: Floats  # of its surface, (n, 3) metres
    grasps: list[Grasp]  # candidates


class HandRunner(ObjectRunner):
    """A table with one object; from whoever they come, grasps are executed by a free hand."""

    def __init__(self, world: World, grasps: pd.DataFrame, trials: HandTrials) -> None:
        """Take a world with one object and a `free_hand`, and labelled grasps of the object."""
        clutter = Clutter(engine=trials.engine, protocol=PROTOCOL, noise=(trials.noise,))
        self._clearing = ClearingRunner(world, clutter)
        super().__init__(trials.engine, self._clearing, self._candidates)
        self._labels = SceneLabels([grasps], world.models, self.gripper)
        self._body = body_of(self.gripper)
        self._usual = IN_SCENES[USUAL[self.gripper.kind.name]]
        self._widest = self.gripper.opening if self.gripper.kind.closes else 0.0
        self._surface = spread(world.model.mesh, SPACING).points
        self._place = _Place(b"", self._surface, [])

    def propose(
        self, detect: Detector, rest: Pose, rng: np.random.Generator
    ) -> list[Grasp] | Outcome | Failure:
        """As in the base class; a fixed jaw stands beside what an image shows, not in its way."""
        return try_to_plan(lambda: self._ranked(self._clearing.ask(detect, rest, rng)))

    def naive(self, rest: Pose, rng: np.random.Generator) -> Grasp | None:
        """A naive grasp; None if no part of the surface faces up."""
        deepest = np.inf if self.gripper.kind.closes else 0.0
        pose = sample_pose(self.world.model.mesh, self.gripper, rng, rest.matrix, deepest)
        return None if pose is None else Grasp.of_pose(pose, self._widest, 0.0)

    def can_do(self, grasp: Grasp) -> bool:
        """Whether the hand can execute a grasp of the object where it was last searched for."""
        return super().can_do(grasp) and self._is_free(grasp)

    def attempt(self, rest: Pose, grasp: Grasp, deviation: Deviation = EXACT) -> HandResult:
        """Try a grasp of the object where it lies."""
        try:
            outcome = self._outcome(rest, grasp, deviation)
            end = self.world.pose()
        except UnstableError:
            return HandResult(Outcome.FAILED, Cause.ENGINE)
        if outcome == Outcome.COLLIDED:
            return HandResult(outcome, self._touching())
        if outcome != Outcome.SUCCESS:
            return HandResult(outcome, OF_OUTCOME[outcome])
        turn = Rotation.from_quat(end.quaternion) * Rotation.from_quat(rest.quaternion).inv()
        angle = float(np.degrees(turn.magnitude()))
        return HandResult(outcome, Cause.SWUNG if angle > SWING else Cause.HELD, angle)

    def _outcome(self, rest: Pose, grasp: Grasp, deviation: Deviation) -> Outcome:
        """The outcome of an attempt, at whose end the object is held up for a while."""
        on_table = [RestingObject(0, rest)]
        outcome = self._clearing.try_proposal(grasp, on_table, deviation).outcome
        if outcome not in (Outcome.SUCCESS, Outcome.SLIPPED_LIFTING):
            return outcome or Outcome.FAILED
        if not self._carries():
            return Outcome.SLIPPED_LIFTING
        self.world.step(round(HOLD / TIME_STEP))
        return Outcome.SUCCESS if self._carries() else Outcome.DROPPED

    def _carries(self) -> bool:
        """Whether the object touches the hand and not the table."""
        forces = self.world.forces()
        return (self.world.attached == 0 or forces.hand > 0) and not forces.support > 0

    def _touching(self) -> Cause:
        """What of the hand just met something."""
        forces = self.world.forces()
        met = {
            Cause.PALM: forces.rest,
            Cause.FINGER: max(forces.left, forces.right),
            Cause.TABLE: forces.blocked,
        }
        return max(met, key=met.__getitem__)

    def _candidates(self, rest: Pose) -> list[Grasp]:
        """Grasps to search among: from above and labelled in turn; naive ones if these are few."""
        key = rest.position.tobytes() + rest.quaternion.tobytes()
        if key != self._place.key:
            self._place = _Place(key, moved(self._surface, rest.matrix), [])
            present, rng = [RestingObject(0, rest)], generator(0, "candidates of a hand")
            labelled = list(islice(self._labels.possible(present), MAX_PROPOSALS))
            view = self._clearing.observe(present, "none", [], rng).view
            above = self._ranked(self._usual(view, self.gripper, rng))
            both = zip_longest(above if isinstance(above, list) else [], labelled)
            grasps = [grasp for pair in both for grasp in pair if grasp]
            if len(grasps) < MAX_PROPOSALS:
                naive = [self.naive(rest, rng) for _ in range(SAMPLED)]
                grasps += [grasp for grasp in naive if grasp and self.can_do(grasp)]
            self._place.grasps.extend(grasps)
        return self._place.grasps

    def _ranked(self, answer: Answer) -> list[Grasp] | Outcome:
        """The grasps of an answer that the hand can execute, best first; or why there is none."""
        if not isinstance(answer, GraspPoses) and isinstance(self._body, JawBody):
            answer = [self._beside_fixed_jaw(grasp, self._body) for grasp in answer]
        return ranked(answer, self.gripper, MAX_PROPOSALS)

    def _beside_fixed_jaw(self, grasp: Grasp, body: JawBody) -> Grasp:
        """A grasp from above whose fixed jaw stands beside what an image shows, as in trials."""
        distance = expected_distance(grasp.width, self.gripper)
        if distance is None:
            return grasp
        width, opening = np.array([distance]), np.array([grasp.width])
        pose = grasp.as_pose(self.gripper).pose.copy()
        pose[:3, 3] += body.aside(width, opening, FIXED_SIDE_CLEARANCE)[0] * pose[:3, 0]
        pose[:3, 3] -= (body.reach(width) - body.reach(opening))[0] * pose[:3, 2]
        return Grasp.of_pose(pose, grasp.width, grasp.quality)

    def _is_free(self, grasp: Grasp) -> bool:
        """Whether jaws meet neither the object nor the table on their way, as boxes."""
        if not self.gripper.kind.closes:
            return True
        poses, widths = grasp.pose[None], np.array([grasp.width])
        return not in_collision(poses, widths, self._place.points, self.gripper)[0]

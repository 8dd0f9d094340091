"""labels: the best labelled grasp of any object in a scene, knowing where all of them are."""

from collections.abc import Iterator, Sequence
from functools import cached_property

import numpy as np
import pandas as pd
import trimesh
from numpy.typing import NDArray

from egad._util.arrays import Floats
from egad.bench.scenes import WORKSPACE, RestingObject
from egad.detectors import Grasp, Observation
from egad.geometry import RayCaster, joined
from egad.grasps import blocked_turns, hand_poses, vectors
from egad.grasps.suction import collision_free, loads_in_frames, resists, seal_cups
from egad.grippers import Gripper, HandBody, body_of, cup_of
from egad.grippers.kinds import CupKind, JawKind
from egad.sim import Model
from egad.sim.execution import STANDOFF
from egad.sim.world import DOWN
from egad.tables.outcomes import Outcome

TURNS = 2 * np.pi * np.arange(16) / 16  # about the closing axis, from the labelled approach
TABLE_SLAB = trimesh.creation.box([2 * WORKSPACE, 2 * WORKSPACE, 0.1])
TABLE_SLAB.apply_translation([0.0, 0.0, -0.05])
CHUNK = 32  # grasps that are tested at once
MAX_TESTED = 640  # grasps that are tested in all
# The table, metres
TABLE = WORKSPACE * np.array(
    [[[-1, -1, 0], [1, -1, 0], [1, 1, 0]], [[-1, -1, 0], [1, 1, 0], [-1, 1, 0]]]
)


class SceneLabels:
    """Labelled grasps of objects, to be proposed wherever they lie (ours)."""

    def __init__(
        self, grasps: Sequence[pd.DataFrame], models: Sequence[Model], gripper: Gripper
    ) -> None:
        """Keep the grasps of each object that the hand can reach with nothing else there."""
        self._grasps = [table[table["collision_free"]] for table in grasps]
        self._models = models
        self._gripper = gripper

    def __call__(
        self, observation: Observation, present: Sequence[RestingObject], rng: np.random.Generator
    ) -> Grasp | Outcome:
        """The grasp of the highest robust quality with a free, straight approach.

        Of 16 directions around the closing axis, the hand takes the free one that points down most.
        A cup approaches as labelled, where it seals and holds the weight.
        """
        del observation, rng
        return next(self.possible(present), Outcome.NO_GRASP)

    def possible(self, present: Sequence[RestingObject]) -> Iterator[Grasp]:
        """The grasps that `__call__` chooses from, best first, computed lazily."""
        by_kind = {JawKind.name: self._with_jaws, CupKind.name: self._with_cup}
        return by_kind[self._gripper.kind.name](*self._candidates(present), present)

    def _with_jaws(
        self, frames: Floats, widths: Floats, quality: Floats, present: Sequence[RestingObject]
    ) -> Iterator[Grasp]:
        """The grasps of jaws in the scene, best first."""
        opening, body = self._gripper.opening, self._body
        hand = body.parts(STANDOFF)
        behind = body.reach(widths) - body.reach(np.array([opening]))
        aside = body.aside(widths, np.array([opening]))
        frames[:, :3, 3] += aside[:, None] * frames[:, :3, 0]  # the open hand
        scene = np.concatenate([TABLE, *(self._triangles(each) for each in present)])
        best = np.argsort(-quality, kind="stable")[:MAX_TESTED]
        for first in range(0, len(best), CHUNK):
            numbers = best[first : first + CHUNK]
            chosen, back = frames[numbers], behind[numbers]
            rows = np.ascontiguousarray(chosen[:, :3, :3].transpose(0, 2, 1))
            blocked = blocked_turns(scene, hand, chosen[:, :3, 3], rows, TURNS, behind=back)
            for number in np.flatnonzero(~blocked.all(axis=1)).tolist():
                pose = _turned(chosen[number], blocked[number])
                pose[:3, 3] -= back[number] * pose[:3, 2]  # where the open hand is
                yield Grasp.of_pose(pose, opening, float(quality[numbers[number]]))

    @cached_property
    def _body(self) -> HandBody:
        return body_of(self._gripper)

    def _with_cup(
        self, poses: Floats, _widths: Floats, quality: Floats, present: Sequence[RestingObject]
    ) -> Iterator[Grasp]:
        """The grasps of a cup in the scene, best first."""
        cup = cup_of(self._gripper, "a suction grasp")
        best = np.argsort(-quality, kind="stable")
        best = best[quality[best] > 0][:MAX_TESTED]
        counts = [len(self._grasps[each.number]) for each in present]
        owners = np.repeat([each.number for each in present], counts)[best]
        where = {each.number: each.pose.position for each in present}
        masses = [self._models[number].mass for number in owners]
        centers = np.array([where[number] for number in owners]).reshape(-1, 3)
        origins, frames = poses[best, :3, 3], poses[best, :3, :3].transpose(0, 2, 1).copy()
        meshes = [self._models[n].mesh.copy().apply_transform(at.matrix) for n, at in present]
        scene = RayCaster(joined([TABLE_SLAB, *meshes]))
        seals = seal_cups(scene, cup, origins, frames)
        good = seals.sealed & (np.abs(seals.depths) < cup.height)
        good &= collision_free(scene, cup, origins, frames, seals.depths)
        weights = np.array(masses)[:, None] * np.array(DOWN)
        loads = loads_in_frames(origins, frames, weights.reshape(-1, 3), centers)
        for number in best[good & resists(cup, loads)].tolist():
            yield Grasp.of_pose(poses[number], 0.0, float(quality[number]))

    def _candidates(self, present: Sequence[RestingObject]) -> tuple[Floats, Floats, Floats]:
        """All grasps: poses of the hand in the world, (n, 4, 4), widths and robust qualities."""
        poses, widths, quality = [np.empty((0, 4, 4))], [np.empty(0)], [np.empty(0)]
        for number, pose in present:
            table = self._grasps[number]
            matrix = pose.matrix @ self._models[number].to_principal
            scale = np.cbrt(np.linalg.det(matrix[:3, :3]))
            rotation = matrix[:3, :3] / scale
            centers = vectors(table, "center") @ matrix[:3, :3].T + matrix[:3, 3]
            axis, approach = (vectors(table, name) @ rotation.T for name in ("axis", "approach"))
            poses.append(hand_poses(centers, axis, approach))
            widths.append(table["width"].to_numpy(np.float64) * scale)
            quality.append(table["robust_quality"].to_numpy(np.float64))
        return np.concatenate(poses), np.concatenate(widths), np.concatenate(quality)

    def _triangles(self, placed: RestingObject) -> Floats:
        matrix = placed.pose.matrix
        triangles: Floats = self._models[placed.number].mesh.triangles @ matrix[:3, :3].T
        return triangles + matrix[:3, 3]


def _turned(pose: Floats, blocked: NDArray[np.bool_]) -> Floats:
    """A pose of the hand turned about x as `blocked_turns` does: downwards, but not blocked."""
    y, z = pose[:3, 1], pose[:3, 2]
    approaches = np.cos(TURNS)[:, None] * z - np.sin(TURNS)[:, None] * y
    turn = TURNS[np.where(blocked, np.inf, approaches[:, 2]).argmin()]
    turned = pose.copy()
    turned[:3, 1] = np.cos(turn) * y + np.sin(turn) * z
    turned[:3, 2] = np.cos(turn) * z - np.sin(turn) * y
    return turned

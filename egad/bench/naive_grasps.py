"""Naive grasps: straight in at a random point of the surface, at a random turn and depth.

Their success rate says how forgiving an object is, and needs neither a detector nor a model of
quality. (The approach-based sampler of Eppner 2019 without a cone; the depth is also sampled.)
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd
import trimesh

from egad._util.arrays import Flags, Floats
from egad.bench.parameters import NaiveGraspParameters
from egad.bench.scenes import make_scene, put
from egad.grasps import TABLE_CLEARANCE, hand_poses
from egad.grippers import Gripper, check_jaws
from egad.random import generator
from egad.sim import (
    FREE,
    TABLE,
    Arm,
    ContactRules,
    Fingers,
    Lifting,
    Model,
    UnstableError,
    World,
    execute_pose,
    free_hand,
    open_world,
)
from egad.sim.arms import TurningAxis
from egad.sim.execution import STEEP, execute
from egad.sim.labelled_trials import float_before_hand
from egad.tables.outcomes import Outcome

SIDEWAYS = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])


class Touch(NamedTuple):
    """A point of a surface, (3,) metres, and the outward unit normal there, (3,)."""

    point: Floats
    normal: Floats


def sample_touch(mesh: trimesh.Trimesh, chosen: Flags, rng: np.random.Generator) -> Touch:
    """Sample a point on the chosen triangles, (m,), not all without area, uniform by area."""
    sums = np.cumsum(np.asarray(mesh.area_faces) * chosen)
    at, along, across = rng.uniform(size=3)
    face = int(np.searchsorted(sums, at * sums[-1], side="right"))
    root = np.sqrt(along)
    corners = np.asarray(mesh.triangles)[face]
    point: Floats = np.array([1 - root, root * (1 - across), root * across]) @ corners
    return Touch(point, np.asarray(mesh.face_normals)[face])


def approach_pose(touch: Touch, turn: float, depth: float, gripper: Gripper) -> Floats:
    """Pose, (4, 4), of a hand that comes against the normal, turned (rad), `depth` (m) beyond."""
    approach = -touch.normal
    aside = np.cross(approach, SIDEWAYS[int(abs(approach[0]) > abs(approach[1]))])
    aside /= np.linalg.norm(aside)
    axis = np.cos(turn) * aside + np.sin(turn) * np.cross(approach, aside)
    center = touch.point + (depth - gripper.kind.span[1]) * approach
    pose: Floats = hand_poses(center[None], axis[None], approach[None])[0]
    return pose


def sample_pose(
    mesh: trimesh.Trimesh,
    gripper: Gripper,
    rng: np.random.Generator,
    rest: Floats | None = None,
    deepest: float = np.inf,
) -> Floats | None:
    """Sample the pose, (4, 4), of a naive grasp; None if no part of the surface faces up.

    At `rest`, (4, 4), on a table, the hand comes at most 60 degrees off the vertical and stays 3 mm
    above the table. Otherwise the object floats, and the pose is in the frame of the mesh.
    """
    if rest is None:
        touch = sample_touch(mesh, np.ones(len(mesh.faces), dtype=bool), rng)
    else:
        faces_up = mesh.face_normals @ rest[2, :3] >= np.cos(STEEP)
        if not mesh.area_faces[faces_up].any():
            return None
        touch = sample_touch(mesh, faces_up, rng)
        touch = Touch(rest[:3, :3] @ touch.point + rest[:3, 3], rest[:3, :3] @ touch.normal)
        room = float(touch.point[2] - TABLE_CLEARANCE) / touch.normal[2]
        deepest = min(deepest, max(room, 0.0))
    turn, share = rng.uniform(0, np.pi), rng.uniform()
    return approach_pose(touch, turn, share * min(gripper.finger_length, deepest), gripper)


def try_naive_grasps(model: Model, object_id: str, settings: NaiveGraspParameters) -> pd.DataFrame:
    """Try naive grasps of an object, each by itself: rows of `tables.grasping.NAIVE_GRASPS`.

    In free space the object floats until the fingers have closed, as in `labelled_trials`; on the
    table it is dropped. A contact of the open hand on its way is a failure, `collided`.
    """
    check_jaws(settings.gripper, "a naive grasp")
    friction = settings.quality.friction
    gripper = settings.gripper.model_copy(update={"friction": friction})
    arm, engine = TurningAxis(gripper), settings.simulated_label.engine

    def rngs(place: str) -> Iterator[np.random.Generator]:
        for number in range(settings.naive_grasp.grasps):
            yield generator(settings.seed, "naive-grasp", place, object_id, number)

    with open_world(engine, [model], arm.robot) as world:
        free = [try_in_free_space(world, arm, settings.trials, rng) for rng in rngs(FREE)]
    with open_world(engine, [model], free_hand(gripper)) as world:
        table = [try_on_table(world, rng) for rng in rngs(TABLE)]
    return naive_outcomes(free, table, settings)


def naive_outcomes(
    free: Sequence[Outcome], table: Sequence[Outcome], settings: NaiveGraspParameters
) -> pd.DataFrame:
    """Outcomes in free space and on the table, as a table like that of `try_naive_grasps`."""
    rows = [
        (place, number, outcome.value)
        for place, outcomes in ((FREE, free), (TABLE, table))
        for number, outcome in enumerate(outcomes)
    ]
    found = pd.DataFrame(rows, columns=["place", "number", "outcome"])
    return found.assign(engine=settings.simulated_label.engine)


def try_in_free_space(
    world: World, arm: Arm, lifting: Lifting, rng: np.random.Generator, deepest: float = np.inf
) -> Outcome:
    """Try a naive grasp of a floating object; see `try_naive_grasps`."""
    gripper, mesh = arm.robot.gripper, world.model.mesh
    pose = sample_pose(mesh, gripper, rng, deepest=deepest)
    if pose is None:
        return Outcome.NO_GRASP
    to_hand = np.linalg.inv(pose).astype(np.float64)
    start, grasp = float_before_hand(to_hand, float(mesh.scale), gripper)
    world.reset()
    world.place(start)
    return execute(world, arm, lifting, grasp, afloat=True).outcome


def try_on_table(world: World, rng: np.random.Generator, deepest: float = np.inf) -> Outcome:
    """Drop an object in the world of a free hand and try a naive grasp; see `try_naive_grasps`."""
    gripper = Fingers(world).gripper
    try:
        present = make_scene(world, "single", rng)
    except UnstableError:
        return Outcome.FAILED
    pose = sample_pose(world.model.mesh, gripper, rng, present[0].pose.matrix, deepest)
    if pose is None:
        return Outcome.NO_GRASP
    put(world, present)
    return execute_pose(world, pose, gripper.opening, ContactRules("collided")).outcome

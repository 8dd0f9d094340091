"""Labelled scenes: objects come to rest, cameras see them, and a hand tries grasps (ours)."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from egad._util.arrays import Floats
from egad.bench import (
    WORKSPACE,
    RestingObject,
    SceneCameras,
    camera_poses,
    intrinsics_of,
    open_round,
    put,
)
from egad.bench import make_scene as put_objects
from egad.detectors import DepthCamera, Observation, View, add_noise, render_scene
from egad.geometry import nearest
from egad.grasps import hand_poses
from egad.grippers import check_jaws, finger_span
from egad.learning.images import coded, png, pose_values
from egad.learning.scenes.parameters import DEPTHS, SceneParameters
from egad.learning.scenes.planning import PlannedScene
from egad.random import generator
from egad.sim import ContactRules, Execution, Fingers, Model, UnstableError, World, execute_pose
from egad.tables.columns import POSE_PARTS
from egad.tables.outcomes import Outcome
from egad.tables.scenes import SCENE_GRASPS

MIN_RISE = -0.1  # z of the outward normal of a grasp point: not from below, as in VGN's code


class MadeScene(NamedTuple):
    """A scene as a row of `tables.scenes.SCENES` and rows of `SCENE_GRASPS`."""

    scene: dict[str, Any]
    grasps: pd.DataFrame


class YawTrials(NamedTuple):
    """A grasp tried at `yaws`: pose (4, 4), width (m, NaN if it fails), outcome of the best."""

    pose: Floats
    width: float
    yaws: list[bool]
    outcome: Outcome


def make_scene(
    planned: PlannedScene, models: Mapping[str, Model], settings: SceneParameters
) -> MadeScene | None:
    """Make a scene, with images and labelled grasps; None if the simulation goes wrong."""
    check_jaws(settings.gripper, "labelled scenes")
    this = planned.round
    with open_round(this, models, settings.clutter) as world:
        rng = generator(this.seed, "scene", this.scene)
        try:
            present = put_objects(world, this.scene, rng, settings.scenes.protocol)
        except UnstableError:
            return None
        views = see(world, present, settings.scenes.cameras, generator(this.seed, "cameras"))
        cloud = Observation(views[0], views, WORKSPACE).cloud
        rng = generator(this.seed, "grasps")
        points, normals = sample_points(*cloud, settings.scenes.grasps, rng)
        tried = [
            try_yaws(world, present, poses_of, settings)
            for poses_of in hand_poses_at(points, normals, settings, rng)
        ]
        owners = nearest_objects(points, world, present)
    ids = [this.ids[each.number] for each in present]
    factors = [this.factors[each.number] for each in present]
    matrices = [_placement(each, world.models[each.number]) for each in present]
    noise_rng = generator(this.seed, "noise")
    row = {
        "scene": this.number,
        "kind": this.scene,
        "split": planned.split,
        "objects": ids,
        "factors": factors,
        "placements": [value for each in matrices for value in pose_values(each)],
        "noise": this.noise,
        **view_columns([add_noise(this.noise, view, noise_rng) for view in views]),
    }
    return MadeScene(row, grasp_table(this.number, ids, owners, tried))


def see(
    world: World, present: Sequence[RestingObject], cameras: SceneCameras, rng: np.random.Generator
) -> tuple[View, ...]:
    """What ideal cameras see of objects where they lie."""
    rendered = [DepthCamera(world.models[each.number].mesh) for each in present]
    matrices = [each.pose.matrix for each in present]
    intrinsics = intrinsics_of(cameras)
    # each at its own distance and tilt
    poses = [camera_poses(cameras, rng)[number] for number in range(cameras.views)]
    return tuple(render_scene(rendered, matrices, intrinsics, pose) for pose in poses)


def sample_points(
    points: Floats, normals: Floats, count: int, rng: np.random.Generator
) -> tuple[Floats, Floats]:
    """`count` points and normals, (n, 3), of a cloud; one may occur twice; none if it has none."""
    allowed = np.flatnonzero(normals[:, 2] > MIN_RISE)
    chosen = rng.choice(allowed, count if len(allowed) else 0)
    return points[chosen], normals[chosen]


def hand_poses_at(
    points: Floats, normals: Floats, settings: SceneParameters, rng: np.random.Generator
) -> Floats:
    """Poses against the normals of n points, (n, yaws, 4, 4), at random depths."""
    low, tip = finger_span(settings.gripper)
    count, yaws = len(points), settings.scenes.yaws
    below = rng.uniform(*DEPTHS, size=count) * (tip - low)
    first = rng.uniform(0, np.pi, size=count)
    approaches = -normals
    level = np.where(np.abs(normals[:, :1]) < 0.7, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
    side = np.cross(approaches, level)
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    across = np.cross(side, approaches)
    angles = (first[:, None] + np.pi * np.arange(yaws) / yaws)[..., None]
    axes = np.cos(angles) * across[:, None] + np.sin(angles) * side[:, None]
    centers = points + (below - tip)[:, None] * approaches
    each = [np.repeat(values, yaws, axis=0) for values in (centers, approaches)]
    return hand_poses(each[0], axes.reshape(-1, 3), each[1]).reshape(count, yaws, 4, 4)


def try_yaws(
    world: World, present: Sequence[RestingObject], poses: Floats, settings: SceneParameters
) -> YawTrials:
    """Try a grasp at all its yaws, (yaws, 4, 4); the middle of the widest run is kept."""
    done = [try_grasp(world, present, pose, settings) for pose in poses]
    held = [result.outcome == Outcome.SUCCESS for result, _ in done]
    kept = middle_of_run(held)
    result, width = done[kept]
    yaws = held[kept:] + held[:kept]
    return YawTrials(poses[kept], width if yaws[0] else np.nan, yaws, result.outcome)


def try_grasp(
    world: World, present: Sequence[RestingObject], pose: Floats, settings: SceneParameters
) -> tuple[Execution, float]:
    """The result of a grasp of the fully open hand, and how far it is open in the end, metres."""
    put(world, present)
    rules = settings.scenes.protocol
    contacts = ContactRules(
        "collided", rules.stopping_force, rules.success == "pinched", rules.removed == "first"
    )
    result = execute_pose(world, pose, settings.gripper.opening, contacts)
    return result, Fingers(world).opening()


def middle_of_run(flags: Sequence[bool]) -> int:
    """Index of the middle of the longest run of true flags on a circle; 0 if there is none."""
    count, best = len(flags), (0, 0)
    for first in range(count):
        length = next((n for n in range(count) if not flags[(first + n) % count]), count)
        best = max(best, (length, -first))
    length, first = best[0], -best[1]
    return (first + max(length - 1, 0) // 2) % count


def nearest_objects(points: Floats, world: World, present: Sequence[RestingObject]) -> list[int]:
    """Which of the present objects has the nearest surface to each point (n, 3)."""
    if not len(points):
        return []
    distances = []
    for number, pose in present:
        local = (points - pose.position) @ pose.matrix[:3, :3]
        distances.append(nearest(local, world.models[number].mesh)[0])
    return [int(number) for number in np.argmin(distances, axis=0)]


def grasp_table(
    scene: int, ids: Sequence[str], owners: Sequence[int], tried: Sequence[YawTrials]
) -> pd.DataFrame:
    """Columns of `tables.scenes.SCENE_GRASPS`."""
    rows = [
        {
            "scene": scene,
            "object": owner,
            "id": ids[owner],
            **dict(zip(POSE_PARTS, pose_values(each.pose), strict=True)),
            "width": each.width,
            "success": each.yaws[0],
            "yaws": each.yaws,
            "outcome": each.outcome.value,
        }
        for owner, each in zip(owners, tried, strict=True)
    ]
    return pd.DataFrame(rows, columns=SCENE_GRASPS.names)


def view_columns(views: Sequence[View]) -> dict[str, Any]:
    """The columns of `tables.scenes.SCENES` that hold views of the same camera."""
    camera = views[0].intrinsics
    return {
        "height": camera.height,
        "width": camera.width,
        "focal": float(camera.focal),
        "center_u": camera.center[0],
        "center_v": camera.center[1],
        "cameras": [value for view in views for value in pose_values(view.pose)],
        "depth": [png(coded(view.depth)) for view in views],
        "mask": [png(view.mask) for view in views],
    }


def _placement(placed: RestingObject, model: Model) -> Floats:
    """Where the frame of the mesh is, (4, 4), without its size."""
    matrix = placed.pose.matrix @ model.to_principal
    matrix[:3, :3] /= np.cbrt(np.linalg.det(matrix[:3, :3]))
    return matrix

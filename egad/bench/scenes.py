"""Scenes of several objects on a table: each alone, packed side by side, or in a pile."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import trimesh
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from egad._util.arrays import Floats
from egad.bench.protocols import ClutterProtocol, SceneKind
from egad.sim import TIME_STEP, Model, Pose, UnstableError, World, moved

# As in VGN's repository (Breyer et al. 2020), unless it says "ours".
WORKSPACE = 0.3  # metres, side of the cube; what leaves it is removed
BOX = 0.26  # inner side of the box that a pile is dropped into
DROP_AREA = 0.1  # side of the square above which objects are dropped
STAND = 0.002  # height above the table at which packed objects are placed
SCENE_TRIES = 10  # ours: scenes without any object in the workspace are made again
SETTLING_TIME = 2.0  # seconds, at most
REST_SPEED = 0.01  # m/s and rad/s
REST_TIME = 0.1  # ours: seconds that all objects must be slower than that
EGAD: ClutterProtocol = ClutterProtocol()


class RestingObject(NamedTuple):
    """An object in a scene: its number in the world, and where it lies."""

    number: int
    pose: Pose


def make_scene(
    world: World, kind: SceneKind, rng: np.random.Generator, protocol: ClutterProtocol = EGAD
) -> list[RestingObject]:
    """Put the objects of a world on the table in turn; those in the workspace, by number.

    single, pile: dropped at random, a pile into a box that is then removed; packed: upright, turned
    at random, beside those that lie still. UnstableError if no object stays.
    """
    for _ in range(SCENE_TRIES):
        if present := _try_scene(world, kind, rng, protocol):
            return present
    raise UnstableError("no object stays in the workspace")


def _try_scene(
    world: World, kind: SceneKind, rng: np.random.Generator, protocol: ClutterProtocol
) -> list[RestingObject]:
    """The objects that stay in the workspace, perhaps none."""
    world.reset()
    if kind == "packed":
        present = _pack(world, rng, protocol)
    else:
        present = list(range(len(world.models)))
        top = 0.0
        for number in present:
            world.place(_above(world.models[number].mesh, top, rng, protocol), number=number)
            settle(world)
            top = max(top, float(world.vertices(number)[:, 2].max()))
    world.remove_walls()
    return settle_all(world, present)


def settle_all(world: World, present: Sequence[int]) -> list[RestingObject]:
    """Let objects come to rest, and remove those that are then outside the workspace."""
    left = list(present)
    while True:
        settle(world)
        inside = [number for number in left if in_workspace(world.pose(number).position)]
        for number in set(left) - set(inside):
            world.park(number)
        if inside == left:
            return [RestingObject(number, world.pose(number)) for number in left]
        left = inside


def settle_from(world: World, objects: Sequence[RestingObject]) -> list[RestingObject]:
    """Let objects come to rest from their current poses, with nothing else in the world."""
    put(world, objects)
    return settle_all(world, [each.number for each in objects])


def put(world: World, objects: Sequence[RestingObject]) -> None:
    """Place objects at rest in an empty world."""
    world.reset()
    world.remove_walls()
    for each in objects:
        world.place(each.pose, number=each.number)


def settle(
    world: World,
    seconds: float = SETTLING_TIME,
    speed: float = REST_SPEED,
    turning: float = REST_SPEED,
) -> bool:
    """Whether all objects come to rest in some time: slower than that, m/s and rad/s."""
    still, pause = 0, round(REST_TIME / TIME_STEP)
    for _ in range(round(seconds / TIME_STEP)):
        world.step()
        now = world.speeds()
        still = still + 1 if now[0] < speed and now[1] < turning else 0
        if still == pause:
            return True
    return False


def in_workspace(position: Floats) -> bool:
    """Whether a center of mass is in the workspace: a cube that stands on the table."""
    half = WORKSPACE / 2
    return bool((np.abs(position[:2]) <= half).all() and 0 <= position[2] <= WORKSPACE)


def _above(
    mesh: trimesh.Trimesh, top: float, rng: np.random.Generator, protocol: ClutterProtocol
) -> Pose:
    """A pose in a random orientation, above the middle and any objects there."""
    turn = Rotation.random(rng=rng)
    x, y = rng.uniform(-DROP_AREA / 2, DROP_AREA / 2, size=2)
    height = protocol.drop_height
    if protocol.drop_above == "objects":
        height = top + height - float(turn.apply(mesh.vertices)[:, 2].min())
    return Pose(np.array([x, y, height]), turn.as_quat())


def _pack(world: World, rng: np.random.Generator, protocol: ClutterProtocol) -> list[int]:
    """Place objects upright, none above or below another; return the numbers of those that fit."""
    present: list[int] = []
    taken: list[ConvexHull] = []
    left = protocol.packing_tries
    for number, model in enumerate(world.models):
        if protocol.packing_tries_of == "object":
            left = protocol.packing_tries
        while left:
            left -= 1
            pose = _upright(model, rng, protocol.packing_area)
            footprint = ConvexHull(moved(model.mesh.vertices, pose.matrix)[:, :2])
            if all(_apart(footprint, other) for other in taken):
                world.place(pose, number=number)
                settle(world)
                present.append(number)
                taken = [ConvexHull(world.vertices(each)[:, :2]) for each in present]
                break
    return present


def _apart(first: ConvexHull, second: ConvexHull) -> bool:
    """Whether two polygons have no point in common: all of one lie beyond an edge of the other."""
    return any(
        bool((one.equations[:, :2] @ other.points.T + one.equations[:, 2:] > 0).all(axis=1).any())
        for one, other in ((first, second), (second, first))
    )


def _upright(model: Model, rng: np.random.Generator, area: float) -> Pose:
    """A pose just above the table, rotated about the vertical and shifted at random."""
    scaled = model.to_principal[:3, :3]
    own = Rotation.from_matrix(scaled.T / np.sqrt((scaled[0] ** 2).sum()))
    turn = Rotation.from_euler("z", rng.uniform(0, 2 * np.pi)) * own
    x, y = rng.uniform(-area / 2, area / 2, size=2)
    lowest = float(turn.apply(model.mesh.vertices)[:, 2].min())
    return Pose(np.array([x, y, STAND - lowest]), turn.as_quat())

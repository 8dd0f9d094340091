"""Where the object falls from when an attempt begins, as in a trial with a real robot."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from egad.sim.world import Pose

Floats = NDArray[np.float64]

DROP_SPREAD = 0.03  # the centre of mass is dropped at most this far from the middle, both ways
DROPS = 5
# Let go upright, six of seven objects lie as before, and the same grasp works 20 times.
TILT = np.pi / 2
MOVED = 0.01  # metres; if no point moved further, a detector would try the same again


class Start(NamedTuple):
    """The object at rest in some pose, from which it falls.

    Attributes:
        begun: dropped: put above the middle in a random orientation; from_hand: let go by the
            hand that held it, there too; left: where the attempt before left it.
        pose: Of the object.
    """

    begun: str
    pose: Pose


def starts(
    mesh: trimesh.Trimesh, height: float, left: Start | None, rng: np.random.Generator
) -> Iterator[Start]:
    """What to try, one after the other, until the object lies still in the workspace.

    Args:
        mesh: The object, in the frame of its poses.
        height: Of its lowest point when it is dropped, metres.
        left: Where the attempt before left it: lying, or in the hand, which tilts and turns it by
            chance above the middle; None if it is put back.
        rng: Source of chance.
    """
    if left is not None and left.begun == "from_hand":
        turned = _tilted(left.pose.quaternion, rng)
        yield Start("from_hand", _above(mesh, height, turned, rng))
    elif left is not None:
        yield left
    for _ in range(DROPS):
        quaternion = rng.normal(size=4)
        quaternion /= np.linalg.norm(quaternion)
        yield Start("dropped", _above(mesh, height, quaternion, rng))


def moved(mesh: trimesh.Trimesh, before: Pose, after: Pose) -> bool:
    """Whether any point of an object moved by more than `MOVED`."""
    change = after.matrix - before.matrix
    shifts = mesh.vertices @ change[:3, :3].T + change[:3, 3]
    return bool((np.linalg.norm(shifts, axis=1) > MOVED).any())


def _above(
    mesh: trimesh.Trimesh, height: float, quaternion: Floats, rng: np.random.Generator
) -> Pose:
    """Above the middle of the table, give or take `DROP_SPREAD`."""
    x, y = rng.uniform(-DROP_SPREAD, DROP_SPREAD, size=2)
    turned = mesh.vertices @ Pose(np.zeros(3), quaternion).matrix[2, :3]
    return Pose(np.array([x, y, height - turned.min()]), quaternion)


def _tilted(quaternion: Floats, rng: np.random.Generator) -> Floats:
    """A quaternion (x, y, z, w), tilted any way by at most `TILT` and turned about the vertical."""
    turn, way = rng.uniform(-np.pi, np.pi, size=2)
    axis = np.array([np.cos(way), np.sin(way), 0.0])
    tilt = Rotation.from_rotvec(axis * rng.uniform(0, TILT))
    tilted: Floats = (
        Rotation.from_euler("z", turn) * tilt * Rotation.from_quat(quaternion)
    ).as_quat()
    return tilted

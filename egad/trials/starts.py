"""Where the object falls from when an attempt begins, as in a trial with a real robot."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import trimesh
from numpy.typing import NDArray

from egad.trials.world import Pose

Floats = NDArray[np.float64]

DROP_SPREAD = 0.03  # the centre of mass is dropped at most this far from the middle, both ways
DROPS = 5
MOVED = 0.001  # metres; an object of which no point moved further was not touched


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
    mesh: trimesh.Trimesh, height: float, held: Pose | None, lying: Pose | None,
    rng: np.random.Generator,
) -> Iterator[Start]:  # fmt: skip
    """What to try, one after the other, until the object lies still in the workspace.

    Args:
        mesh: The object, in the frame of its poses.
        height: Of its lowest point when it is dropped, metres.
        held: Where the hand holds it, if it does: it is turned about the vertical by chance.
        lying: Where it lies, if it may stay there.
        rng: Source of chance.
    """
    if held is not None:
        turn = float(rng.uniform(-np.pi, np.pi))
        yield Start("from_hand", _above(mesh, height, _turned(held.quaternion, turn), rng))
    elif lying is not None:
        yield Start("left", lying)
    for _ in range(DROPS):
        quaternion = rng.normal(size=4)
        quaternion /= np.linalg.norm(quaternion)
        yield Start("dropped", _above(mesh, height, quaternion, rng))


def touched(mesh: trimesh.Trimesh, before: Pose, after: Pose) -> bool:
    """Whether any point of an object moved by more than `MOVED`."""
    change = after.matrix - before.matrix
    moved = mesh.vertices @ change[:3, :3].T + change[:3, 3]
    return bool((np.linalg.norm(moved, axis=1) > MOVED).any())


def _above(
    mesh: trimesh.Trimesh, height: float, quaternion: Floats, rng: np.random.Generator
) -> Pose:
    """Above the middle of the table, give or take `DROP_SPREAD`."""
    x, y = rng.uniform(-DROP_SPREAD, DROP_SPREAD, size=2)
    turned = mesh.vertices @ Pose(np.zeros(3), quaternion).matrix[2, :3]
    return Pose(np.array([x, y, height - turned.min()]), quaternion)


def _turned(quaternion: Floats, angle: float) -> Floats:
    """A quaternion (x, y, z, w), turned about the vertical."""
    x, y, z, w = quaternion.tolist()
    sine, cosine = np.sin(angle / 2), np.cos(angle / 2)
    return np.array(
        [
            cosine * x - sine * y,
            cosine * y + sine * x,
            cosine * z + sine * w,
            cosine * w - sine * z,
        ]
    )

"""Training examples for VGN's network: the grid of a scene, and its labelled grasps at voxels.

As in VGN's code (ethz-asl/vgn, branch corl2020), a grasp belongs to the voxel whose number is
nearest to its position, in voxels from the corner of the cube. Ours is that a scene is an example
with all of its grasps, so that the network is computed once for all of them.
"""

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from egad._util.arrays import Floats, Singles
from egad.grippers import Gripper
from egad.learning.dataset import Passes
from egad.learning.volumes import encode, hand_in_network_frame
from egad.perception import Observation, Tsdf
from egad.random import generator

WINDOW = 128  # scenes that are shuffled together, about
HALF_TURN = np.diag([-1.0, -1.0, 1.0])  # about the approach: the same grasp


class Scene(Protocol):
    """What is read of a labelled scene."""

    @property
    def view_count(self) -> int:
        """How many depth images there are."""

    @property
    def grasps(self) -> pd.DataFrame:
        """One row per grasp, with `success` and `width`, metres."""

    @property
    def poses(self) -> Floats:
        """Poses of the hand, (n, 4, 4), in the order of `grasps`."""

    def observation(self, views: Sequence[int] | None = None) -> Observation:
        """What some or all of the cameras see."""


class SceneSource(Protocol):
    """Labelled scenes with numbers.

    Attributes:
        index: One row per scene: `split`, `shard`, `grasps` and `positive`.
    """

    index: pd.DataFrame

    def indices(self, split: str) -> NDArray[np.int64]:
        """Rows of the index that belong to a split."""

    def scene(self, number: int) -> Scene:
        """The scene of a row of the index."""


class NetworkGrasps(NamedTuple):
    """Grasps in the frame of a network.

    Attributes:
        poses: (n, 4, 4) in the world.
        success: (n,) 1 or 0.
        widths: (n,) distances of the pads when they hold, metres; 0 for a failed grasp.
    """

    poses: Floats
    success: Singles
    widths: Singles


class SceneExample(NamedTuple):
    """What a network gets, and what it should answer at some voxels.

    Attributes:
        grid: (n, n, n) distances, encoded.
        voxels: (m, 3) voxels of the grasps.
        success: (m,) 1 or 0.
        rotations: (m, 2, 4) both quaternions (x, y, z, w) that mean the grasp, in the frame of VGN.
        widths: (m,) voxels; 0 for a failed grasp.
        voxel: Side of a voxel, metres.
    """

    grid: Singles
    voxels: NDArray[np.int64]
    success: Singles
    rotations: Singles
    widths: Singles
    voxel: float


class Move(NamedTuple):
    """How a scene is moved in its cube.

    Attributes:
        turns: Quarter turns about the vertical through the middle, counterclockwise from above.
        rise: Voxels upwards.
    """

    turns: int = 0
    rise: int = 0


UNMOVED = Move()


def labelled_grasps(scene: Scene, gripper: Gripper) -> NetworkGrasps:
    """The grasps of a scene in the frame of VGN.

    Args:
        scene: With grasps of our hand.
        gripper: The hand.
    """
    poses = scene.poses @ np.linalg.inv(hand_in_network_frame(gripper))
    success = scene.grasps["success"].to_numpy(bool)
    widths = np.where(success, scene.grasps["width"].to_numpy(np.float64), 0)
    return NetworkGrasps(poses, success.astype(np.float32), widths.astype(np.float32))


def scene_example(tsdf: Tsdf, grasps: NetworkGrasps, move: Move = UNMOVED) -> SceneExample:
    """The example of a scene; grasps that the cube does not contain are left out.

    Args:
        tsdf: The scene in a cube.
        grasps: In the frame of VGN.
        move: How both are moved first; what is lifted out of the cube is lost.
    """
    grid, side = encode(tsdf), len(tsdf.distances)
    poses = moved_poses(grasps.poses, tsdf, move)
    voxels = np.round((poses[:, :3, 3] - tsdf.corner) / tsdf.voxel).astype(np.int64)
    kept = ((voxels >= 0) & (voxels < side)).all(axis=1)
    both = np.stack([poses[kept, :3, :3], poses[kept, :3, :3] @ HALF_TURN], axis=1)
    quaternions = Rotation.from_matrix(both.reshape(-1, 3, 3)).as_quat().reshape(-1, 2, 4)
    return SceneExample(
        moved_grid(grid, move),
        voxels[kept],
        grasps.success[kept],
        quaternions.astype(np.float32),
        grasps.widths[kept] / np.float32(tsdf.voxel),
        tsdf.voxel,
    )


def moved_grid(grid: Singles, move: Move) -> Singles:
    """A grid (n, n, n) after a move; nothing is seen where it was empty."""
    turned = np.rot90(grid, move.turns, axes=(0, 1))
    whole = np.zeros_like(grid)
    low, high = max(move.rise, 0), len(grid) + min(move.rise, 0)
    whole[:, :, low:high] = turned[:, :, low - move.rise : high - move.rise]
    return whole


def moved_poses(poses: Floats, tsdf: Tsdf, move: Move) -> Floats:
    """Poses (n, 4, 4) in the world after a move of the cube that they are in."""
    middle = np.append(tsdf.corner[:2] + len(tsdf.distances) * tsdf.voxel / 2, 0)
    moving = np.eye(4)
    moving[:2, :2] = np.linalg.matrix_power(np.array([[0, -1], [1, 0]]), move.turns % 4)
    moving[:3, 3] = middle - moving[:3, :3] @ middle + [0, 0, move.rise * tsdf.voxel]
    moved: Floats = moving @ poses
    return moved


class SceneStream:
    """Shuffled and moved training scenes: pass after pass, each scene once a pass.

    Attributes:
        index: Rows of the index of the scenes that are shown.
    """

    def __init__(
        self,
        scenes: SceneSource,
        gripper: Gripper,
        length: int,
        rise: int = 0,
        seed: int = 0,
        most: int | None = None,
    ) -> None:
        """Make a stream.

        Args:
            scenes: The scenes; those of the split `train` are shown.
            gripper: The hand of their grasps.
            length: How many examples there are.
            rise: Voxels that a scene is moved up or down, at most.
            seed: Order, moves and the numbers of views follow from it.
            most: So many of the scenes, drawn at random, or all of them.

        Raises:
            UserError: There are no such scenes.
        """
        self._scenes, self._gripper, self._length = scenes, gripper, length
        self._rise, self._seed = rise, seed
        numbers = scenes.indices("train")
        if most is not None:
            numbers = np.sort(generator(seed, "scenes").permutation(numbers)[:most])
        self.index = scenes.index.loc[numbers]
        self._passes = Passes(self.index, seed, ["shard"], WINDOW)

    def __len__(self) -> int:
        return self._length

    def __getitem__(self, number: int) -> SceneExample:
        """An example by its number; each number of views is equally likely, and any of them."""
        if not 0 <= number < self._length:
            raise IndexError(number)
        scene = self._scenes.scene(self._passes[number])
        rng = generator(self._seed, "view", number)
        count = int(rng.integers(1, scene.view_count + 1))
        views = sorted(rng.permutation(scene.view_count)[:count].tolist())
        move = Move(int(rng.integers(4)), int(rng.integers(-self._rise, self._rise + 1)))
        tsdf = scene.observation(views).tsdf
        return scene_example(tsdf, labelled_grasps(scene, self._gripper), move)

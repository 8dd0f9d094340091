"""Training examples for VGN's network: the grid of a scene, and its labelled grasps at voxels.

As in VGN's code (ethz-asl/vgn, branch corl2020), a grasp belongs to the voxel whose number is
nearest to its position, in voxels from the corner of the cube. Unlike there, an example is a scene
with all of its grasps, so that the network is computed once for all of them.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from egad._util.arrays import Floats, Singles
from egad.detectors import NoiseName, Observation, Tsdf, add_noise, encode, hand_in_network_frame
from egad.grippers import Gripper
from egad.learning.dataset import Passes
from egad.learning.scenes import LabelledScene, SceneDataset
from egad.random import generator

WINDOW = 128  # scenes that are shuffled together, about


class NetworkGrasps(NamedTuple):
    """Grasps in the frame of a network."""

    poses: Floats  # (n, 4, 4) in the world
    success: Singles  # (n,) 1 or 0
    widths: Singles  # (n,) distances of the pads when they hold, metres; 0 for a failed grasp
    # (n, y) whether it holds when turned about the approach by k / y of half a turn
    yaws: NDArray[np.bool_]


class SceneExample(NamedTuple):
    """The input of a network, and what it should answer at some voxels."""

    grid: Singles  # (n, n, n) distances, encoded
    voxels: NDArray[np.int64]  # (m, 3) voxels of the grasps
    success: Singles  # (m,) 1 or 0
    # (m, 2 y, 4) quaternions (x, y, z, w) at which the grasp holds, in the frame of VGN: those of
    # its yaws, and half a turn further, which is the same grasp. Yaws at which it does not hold are
    # replaced by that of the label
    rotations: Singles
    widths: Singles  # (m,) voxels, at the yaw of the label; 0 for a failed grasp
    voxel: float  # side of a voxel, metres


class Move(NamedTuple):
    """Quarter turns of a scene, counterclockwise from above, and voxels that it is moved up."""

    turns: int = 0
    rise: int = 0


UNMOVED = Move()


def labelled_grasps(scene: LabelledScene, gripper: Gripper) -> NetworkGrasps:
    """The grasps of a scene in the frame of VGN."""
    poses = scene.poses @ np.linalg.inv(hand_in_network_frame(gripper))
    success = scene.grasps["success"].to_numpy(bool)
    widths = np.where(success, scene.grasps["width"].to_numpy(np.float64), 0)
    yaws = np.array([*scene.grasps["yaws"]] or np.empty((0, 1)), bool)
    return NetworkGrasps(poses, success.astype(np.float32), widths.astype(np.float32), yaws)


def scene_example(tsdf: Tsdf, grasps: NetworkGrasps, move: Move = UNMOVED) -> SceneExample:
    """The example of a scene, first moved; grasps that its cube does not contain are left out."""
    grid, side = encode(tsdf), len(tsdf.distances)
    poses = moved_poses(grasps.poses, tsdf, move)
    voxels = np.round((poses[:, :3, 3] - tsdf.corner) / tsdf.voxel).astype(np.int64)
    kept = ((voxels >= 0) & (voxels < side)).all(axis=1)
    return SceneExample(
        moved_grid(grid, move),
        voxels[kept],
        grasps.success[kept],
        held_rotations(poses[kept, :3, :3], grasps.yaws[kept]),
        grasps.widths[kept] / np.float32(tsdf.voxel),
        tsdf.voxel,
    )


def held_rotations(matrices: Floats, yaws: NDArray[np.bool_]) -> Singles:
    """The rotations of `SceneExample`, (m, 2 y, 4), of matrices (m, 3, 3) and yaws (m, y)."""
    count, tried = yaws.shape
    numbers = np.arange(2 * tried)
    turns = np.where(np.tile(yaws, 2), numbers, numbers // tried * tried)
    about = Rotation.from_rotvec(np.outer(np.pi * turns / tried, [0, 0, 1]))
    labels = Rotation.from_matrix(np.repeat(matrices, 2 * tried, axis=0))
    found: Singles = (labels * about).as_quat().reshape(count, 2 * tried, 4).astype(np.float32)
    return found


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
    """Shuffled and moved training scenes: pass after pass, each scene once per pass."""

    def __init__(
        self,
        scenes: SceneDataset,
        gripper: Gripper,
        length: int,
        rise: int = 0,
        seed: int = 0,
        most: int | None = None,
        noise: Sequence[NoiseName] = ("none",),
    ) -> None:
        """Show `most` scenes of `train`, all by default, moved by up to `rise` voxels."""
        self._scenes, self._gripper, self._length = scenes, gripper, length
        self._rise, self._seed, self._noise = rise, seed, tuple(noise)
        numbers = scenes.indices("train")
        if most is not None:
            numbers = np.sort(generator(seed, "scenes").permutation(numbers)[:most])
        self.index = scenes.index.loc[numbers]
        self._passes = Passes(self.index, seed, ["shard"], WINDOW)

    def __len__(self) -> int:
        return self._length

    def __getitem__(self, number: int) -> SceneExample:
        """An example by its number; each number of views is equally likely, and so is each view."""
        if not 0 <= number < self._length:
            raise IndexError(number)
        scene = self._scenes.scene(self._passes[number])
        rng = generator(self._seed, "view", number)
        count = int(rng.integers(1, scene.view_count + 1))
        views = sorted(rng.permutation(scene.view_count)[:count].tolist())
        move = Move(int(rng.integers(4)), int(rng.integers(-self._rise, self._rise + 1)))
        seen = scene.observation(views)
        noise = self._noise[rng.integers(len(self._noise))]
        if scene.noise == "none" and noise != "none":
            noisy = tuple(add_noise(noise, view, rng) for view in seen.views)
            seen = Observation(noisy[0], noisy, seen.side)
        return scene_example(seen.tsdf, labelled_grasps(scene, self._gripper), move)

"""vgn: grasps from the network of VGN, for every voxel of a truncated signed distance field.

Breyer et al., "Volumetric grasping network: real-time 6 DOF grasp detection in clutter", CoRL 2020.
"""

from pathlib import Path

import numpy as np
from scipy import ndimage
from scipy.spatial.transform import Rotation

from egad._util.arrays import Floats, Singles
from egad._util.extras import needed_for
from egad.detectors.base import WHERE, GraspPoses, best_poses
from egad.detectors.collision import in_collision
from egad.detectors.observation import Observation
from egad.detectors.tsdf import Tsdf
from egad.errors import UserError
from egad.grippers import Gripper, finger_span

# Open3D's uniform volume, which VGN was trained with, leaves out what is further from a surface.
FAR = 0.98  # of the truncation
FINGER_DEPTH = 0.05  # metres; VGN's origin lies this far before the fingertips
VGN_WEIGHTS = "the published ones are in the data of the project ethz-asl/vgn: vgn_conv.pth"
SMOOTHING = 1.0  # voxels
NEAR_SURFACE = 2  # voxels
WIDTHS = (1.33, 9.33)  # voxels; predictions beyond these are dropped
OPENING = 0.08  # metres; opening of the hand that these are for, the Panda's
THRESHOLD = 0.9  # of the quality, for weights without their own, such as the published ones
APART = 4  # voxels; side of the cube in which only the best grasp is kept
COLLIDING = 0.1  # by which the quality of a grasp that would collide is multiplied (ours)


class Vgn:
    """VGN's network as a grasp detector."""

    def __init__(
        self, weights: str | None, threshold: float | None = None, avoid_collisions: bool = False
    ) -> None:
        """Load weights, published or safetensors; UserError without PyTorch or fitting weights.

        The default threshold is that noted in the weights, or 0.9. If it avoids collisions, it asks
        for the point cloud, too, and multiplies the quality of a proposal by 0.1 if the hand would
        touch the cloud or the table.
        """
        if weights is None or not Path(weights).is_file():
            missing = "vgn needs `weights: FILE`" if weights is None else f"no such file: {weights}"
            raise UserError(f"{WHERE}: {missing}; {VGN_WEIGHTS}")
        self._weights = weights
        with needed_for("vgn"):
            from egad.detectors import networks  # noqa: PLC0415 (an extra)
            from egad.detectors import weights as files  # noqa: PLC0415
        try:
            self._infer = networks.inference(files.read_vgn(weights))
            own = files.notes_in(weights).get("threshold", THRESHOLD)
            if not (isinstance(own, float) and 0 < own < 1):
                text = f"{weights}: its threshold is {own!r}; allowed: above 0 and below 1"
                raise files.WeightsError(text)
        except files.WeightsError as error:
            raise UserError(f"{error}; {VGN_WEIGHTS}") from error
        self._threshold = own if threshold is None else threshold
        self._avoids_collisions = avoid_collisions

    def __reduce__(self) -> tuple[type["Vgn"], tuple[str, float, bool]]:
        return Vgn, (self._weights, self._threshold, self._avoids_collisions)

    @property
    def observes(self) -> str:
        """What it asks to see."""
        return "observation" if self._avoids_collisions else "tsdf"

    def __call__(
        self, seen: Tsdf | Observation, gripper: Gripper, _rng: np.random.Generator
    ) -> GraspPoses:
        """Grasps at the voxels of the highest quality, with the hand fully open, as in VGN."""
        tsdf = seen.tsdf if isinstance(seen, Observation) else seen
        grid = encode(tsdf)
        answer = self._infer(grid)
        quality = _processed(answer[0], answer[5], grid, widest(gripper))
        high = np.where(quality >= self._threshold, quality, 0)
        voxels = np.argwhere((high > 0) & (high == ndimage.maximum_filter(high, APART)))
        i, j, k = voxels.T
        poses = np.tile(np.eye(4), (len(voxels), 1, 1))
        poses[:, :3, :3] = Rotation.from_quat(answer[1:5, i, j, k].T).as_matrix()
        poses[:, :3, 3] = tsdf.corner + voxels * tsdf.voxel
        poses = poses @ hand_in_network_frame(gripper)
        widths = np.full(len(voxels), gripper.opening)
        scores = quality[i, j, k].astype(np.float64)
        if isinstance(seen, Observation):
            scores[in_collision(poses, widths, seen.cloud.points, gripper)] *= COLLIDING
        return best_poses(GraspPoses(poses, widths, scores))


def widest(gripper: Gripper) -> float:
    """The width up to which grasps are proposed, voxels: VGN's, in proportion for a wider hand."""
    return WIDTHS[1] * max(1.0, gripper.opening / OPENING)


def _processed(quality: Singles, width: Singles, grid: Singles, most: float) -> Singles:
    """The quality smoothed, and 0 where it is far from free space or the width is out of range."""
    smooth: Singles = ndimage.gaussian_filter(quality, SMOOTHING, mode="nearest")
    inside = (grid > 1e-3) & (grid < 0.5)
    near = ndimage.binary_dilation(grid > 0.5, iterations=NEAR_SURFACE, mask=~inside)
    smooth[~near | (width < WIDTHS[0]) | (width > most)] = 0
    return smooth


def encode(tsdf: Tsdf) -> Singles:
    """A field as the network sees it: from 0 inside to 1 outside, 0 far from surfaces."""
    near = (tsdf.weights > 0) & (tsdf.distances < FAR) & (tsdf.distances >= -FAR)
    grid: Singles = np.where(near, (tsdf.distances + 1) / 2, 0).astype(np.float32)
    return grid


def hand_in_network_frame(gripper: Gripper) -> Floats:
    """Our frame of the hand in VGN's, (4, 4), which closes along y, 5 cm before the fingertips."""
    frame = np.eye(4)
    frame[:3, :3] = Rotation.from_euler("z", np.pi / 2).as_matrix()
    frame[2, 3] = FINGER_DEPTH - finger_span(gripper)[1]
    return frame

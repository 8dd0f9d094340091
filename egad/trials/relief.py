"""What stands on the table, as heights, and how deep a hand can reach beside it."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from egad.grasps.room import TABLE_CLEARANCE
from egad.settings import Gripper
from egad.vision.camera import View

Floats = NDArray[np.float64]

PROBE = 0.004  # distance of the points at which the space for the hand is probed


class Relief(NamedTuple):
    """Heights over the table, seen from straight above.

    Attributes:
        heights: Metres, (columns along x, rows along y).
        origin: (2,) the corner of the first cell, world frame.
        cell: Side of a cell, metres.
    """

    heights: Floats
    origin: Floats
    cell: float

    def centroid(self) -> Floats:
        """Centroid of the volume between the table and what is seen, (3,)."""
        weights = self.heights / self.heights.sum()
        x, y = (np.arange(size) + 0.5 for size in self.heights.shape)
        middle = self.origin + self.cell * np.array(
            [x @ weights.sum(axis=1), y @ weights.sum(axis=0)]
        )
        return np.append(middle, (weights * self.heights).sum() / 2)

    def highest(self, points: Floats) -> Floats:
        """The greatest height under points (..., m, 2), over m."""
        index = np.floor((points - self.origin) / self.cell).astype(np.int64)
        last = np.array(self.heights.shape) - 1
        inside = ((index >= 0) & (index <= last)).all(axis=-1)
        index = np.clip(index, 0, last)
        heights = self.heights[index[..., 0], index[..., 1]]
        highest: Floats = np.where(inside, heights, 0.0).max(axis=-1)
        return highest


def relief_of(view: View) -> Relief | None:
    """What stands on the table, as heights on a grid; none if nothing does."""
    points = view.points()
    standing = points[points[..., 2] > TABLE_CLEARANCE]
    if len(standing) == 0:
        return None
    cell = float(np.nanmax(view.depth)) / view.intrinsics.focal
    origin = standing[:, :2].min(axis=0) - 2 * cell
    index = np.floor((standing[:, :2] - origin) / cell).astype(np.int64)
    heights = np.zeros(index.max(axis=0) + 3)
    np.maximum.at(heights, (index[:, 0], index[:, 1]), standing[:, 2])
    # Between the pixels of a steep side are holes, and the probes step over narrow ridges.
    return Relief(np.asarray(ndimage.maximum_filter(heights, 3)), origin, cell)


def lowest_tip(
    middle: Floats, axis: Floats, width: Floats, relief: Relief, gripper: Gripper
) -> Floats:
    """How low the fingertips can go before a finger or the palm meets what is seen.

    Args:
        middle: (n, 2) where the hand is, world frame.
        axis: (n, 2) unit vectors of the closing axis.
        width: (n,) how far the hand is open.
        relief: What is seen.
        gripper: The hand.

    Returns:
        (n,) heights over the table, `TABLE_CLEARANCE` above what is met.
    """
    finger = _probes(gripper.finger_thickness, gripper.finger_width)
    shift = (width + gripper.finger_thickness)[:, None, None] / 2 * np.array([1.0, 0.0])
    below_fingers = np.maximum(
        relief.highest(_placed(finger + shift, middle, axis)),
        relief.highest(_placed(finger - shift, middle, axis)),
    )
    below_palm = relief.highest(_placed(_probes(*gripper.palm[:2])[None], middle, axis))
    clear = np.maximum(below_fingers, below_palm - gripper.finger_length)
    lowest: Floats = np.maximum(clear, 0.0) + TABLE_CLEARANCE
    return lowest


def _probes(length: float, width: float) -> Floats:
    """Points over a rectangle around the origin, not further apart than `PROBE`, (m, 2)."""
    x = np.linspace(-length / 2, length / 2, int(np.ceil(length / PROBE)) + 1)
    y = np.linspace(-width / 2, width / 2, int(np.ceil(width / PROBE)) + 1)
    return np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)


def _placed(points: Floats, middle: Floats, axis: Floats) -> Floats:
    """Points given along and across the closing axis, in the world, (n, m, 2)."""
    across = np.stack([-axis[:, 1], axis[:, 0]], axis=1)
    placed: Floats = (
        middle[:, None] + points[..., :1] * axis[:, None] + points[..., 1:] * across[:, None]
    )
    return placed

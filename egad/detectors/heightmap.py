"""What stands on the table, as heights, and how deep a hand can reach beside it."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from egad._util.arrays import Floats, Ints
from egad.detectors.camera import View, Window
from egad.grasps import TABLE_CLEARANCE
from egad.grippers import Gripper, check_jaws

PROBE = 0.004  # distance of the points at which the space for the hand is probed
BLOCK = 1000  # palms that are probed at a time, with some 1000 points each
NOTHING: Window = (slice(0, 0), slice(0, 0))


class Heightmap(NamedTuple):
    """Heights over the table, seen from straight above."""

    heights: Floats  # metres, (columns along x, rows along y)
    origin: Floats  # (2,) the corner of the first cell, world frame
    cell: float  # side of a cell, metres

    def centroid(self) -> Floats:
        """Centroid of the volume between the table and what is seen, (3,)."""
        weights = self.heights / self.heights.sum()
        x, y = (np.arange(size) + 0.5 for size in self.heights.shape)
        middle = self.origin + self.cell * np.array(
            [x @ weights.sum(axis=1), y @ weights.sum(axis=0)]
        )
        return np.append(middle, (weights * self.heights).sum() / 2)

    def highest(self, points: Floats) -> Floats:
        """The greatest height under points (2, n, m), over m."""
        columns, rows = self.heights.shape
        bordered = np.zeros((columns + 2, rows + 2))  # the border is what lies beside the grid
        bordered[1:-1, 1:-1] = self.heights
        cells = self._cells(points[0], 0) * (rows + 2) + self._cells(points[1], 1)
        highest: Floats = bordered.ravel().take(cells).max(axis=-1)
        return highest

    def _cells(self, values: Floats, axis: int) -> Ints:
        """Numbers of cells in a grid with a border, along an axis."""
        cells = np.floor((values - self.origin[axis]) / self.cell)
        clipped: Ints = np.clip(cells, -1, self.heights.shape[axis], out=cells).astype(np.int64)
        return clipped + 1


def window_of(uneven: NDArray[np.bool_], margin: int) -> Window:
    """The rows and columns that hold all of some pixels, and a margin where the image has one."""
    sides = []
    for axis in (1, 0):
        found = np.flatnonzero(uneven.any(axis=axis))
        if len(found) == 0:
            return NOTHING
        sides.append(slice(max(found[0] - margin, 0), found[-1] + margin + 1))
    return sides[0], sides[1]


def heightmap_of(view: View, window: Window | None = None) -> Heightmap | None:
    """What stands on the table (within the window, if known), as heights; None if nothing does."""
    points = view.points(window or window_of(view.heights() > TABLE_CLEARANCE, 1))
    standing = points[points[..., 2] > TABLE_CLEARANCE]
    if len(standing) == 0:
        return None
    cell = float(np.nanmax(view.depth)) / view.intrinsics.focal
    origin = standing[:, :2].min(axis=0) - 2 * cell
    index = np.floor((standing[:, :2] - origin) / cell).astype(np.int64)
    heights = np.zeros(index.max(axis=0) + 3)
    np.maximum.at(heights, (index[:, 0], index[:, 1]), standing[:, 2])
    # Between the pixels of a steep side are holes, and the probes step over narrow ridges.
    return Heightmap(np.asarray(ndimage.maximum_filter(heights, 3)), origin, cell)


def min_fingertip_height(
    middle: Floats, axis: Floats, width: Floats, heightmap: Heightmap, gripper: Gripper
) -> Floats:
    """Lowest height of the fingertips, (n,) m, above all that finger and palm would meet."""
    check_jaws(gripper, "the minimum height of the fingertips")
    along, across = _probes(gripper.finger_thickness, gripper.finger_width)
    shift = (width + gripper.finger_thickness)[:, None] / 2
    clear = np.maximum(
        heightmap.highest(_placed(along + shift, across, middle, axis)),
        heightmap.highest(_placed(along - shift, across, middle, axis)),
    )
    # The palm counts only where the fingers could go so deep that it meets the highest point.
    deep = np.flatnonzero(np.maximum(clear, 0.0) < heightmap.heights.max() - gripper.finger_length)
    for some in np.array_split(deep, len(deep) // BLOCK + 1):
        palm = _placed(*_probes(*gripper.palm[:2]), middle[some], axis[some])
        clear[some] = np.maximum(clear[some], heightmap.highest(palm) - gripper.finger_length)
    lowest: Floats = np.maximum(clear, 0.0) + TABLE_CLEARANCE
    return lowest


def _probes(length: float, width: float) -> tuple[Floats, Floats]:
    """A grid over a rectangle around the origin, not further apart than `PROBE`: x and y."""
    x = np.linspace(-length / 2, length / 2, int(np.ceil(length / PROBE)) + 1)
    y = np.linspace(-width / 2, width / 2, int(np.ceil(width / PROBE)) + 1)
    return x, y


def _placed(along: Floats, across: Floats, middle: Floats, axis: Floats) -> Floats:
    """X and y in the world, (2, n, k * l), of n grids with coordinates (k,) or (n, k), and (l,)."""
    sides = (axis[:, 0], -axis[:, 1]), (axis[:, 1], axis[:, 0])
    placed = [
        (start[:, None] + along * first[:, None])[..., None] + across * second[:, None, None]
        for start, (first, second) in zip(middle.T, sides, strict=True)
    ]
    return np.stack(placed).reshape(2, len(middle), along.shape[-1] * len(across))

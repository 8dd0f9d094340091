"""labels: the best labelled grasp, knowing where the object is, to tell what labels are worth.

It is not a rival of detectors, because it knows the pose. Nor is it a bound for them: the labels'
model of contacts knows neither gravity nor the table, and there are grasps that were never
labelled.
"""

import logging

import numpy as np
import pandas as pd
import trimesh

from egad._util.arrays import Floats
from egad.detectors.base import SEARCH, Grasp, rank_grasps
from egad.detectors.camera import View
from egad.detectors.heightmap import heightmap_of, min_fingertip_height
from egad.detectors.restoration import restore
from egad.errors import RejectedError
from egad.grasps import MIN_DEPTH, LabelParameters, roomy, vectors
from egad.grasps.sampling import dataset_grasps
from egad.grippers import Gripper, finger_span
from egad.grippers.kinds import CupKind, JawKind
from egad.tables.grasping import GRASPS
from egad.tables.parquet import empty

log = logging.getLogger(__name__)

TILT = np.radians(15)  # of the closing axis, which the hand holds level
CUP_TILT = np.radians(10)  # of the approach of a suction cup, which the hand holds upright


class Labels:
    """Labelled grasps of an object, to be proposed wherever it lies (ours)."""

    def __init__(self, grasps: pd.DataFrame) -> None:
        """Keep the grasps of an object (`GRASPS`) that the hand can reach from some side."""
        free = grasps[grasps["collision_free"]]
        self._center = free[["center_x", "center_y", "center_z"]].to_numpy(np.float64)
        self._axis = free[["axis_x", "axis_y", "axis_z"]].to_numpy(np.float64)
        self._width = free["width"].to_numpy(np.float64)
        self._free = free
        self._quality = free["robust_quality"].to_numpy(np.float64)

    def propose(self, matrix: Floats, view: View, gripper: Gripper) -> list[Grasp]:
        """At most 50 grasps whose closing axis is within 15 degrees of level, best first.

        They leave room for the hand: the space is looked up straight from above in the restored
        depth image, for a hand that opens 8 mm wider than the contacts on either side, or as wide
        as it can where that reaches lower. The pads are centered on the contacts, or as low as they
        can get. The quality is the robust quality. The matrix, (4, 4), is from the frame of the
        grasps to the world.

        For a suction cup, the grasps are those whose approach is within 10 degrees of straight
        down, because it comes straight down. Their quality is the robust quality times the cosine
        of that angle.
        """
        by_kind = {JawKind.name: self._for_jaws, CupKind.name: self._for_cup}
        return by_kind[gripper.kind.name](matrix, view, gripper)

    def _for_jaws(self, matrix: Floats, view: View, gripper: Gripper) -> list[Grasp]:
        heightmap = heightmap_of(restore(view))
        axis = self._axis @ matrix[:3, :3].T
        level = np.flatnonzero(np.abs(axis[:, 2]) <= np.sin(TILT))
        if heightmap is None or len(level) == 0:
            return []
        center = self._center[level] @ matrix[:3, :3].T + matrix[:3, 3]
        flat = axis[level, :2] / np.linalg.norm(axis[level, :2], axis=1, keepdims=True)
        narrow = roomy(self._width[level], gripper)
        wide = np.full_like(narrow, gripper.opening)
        pad = finger_span(gripper)[1]
        tips = [
            np.maximum(
                center[:, 2] - pad,
                min_fingertip_height(center[:, :2], flat, width, heightmap, gripper),
            )
            for width in (narrow, wide)
        ]
        tip, width = np.minimum(*tips), np.where(tips[0] <= tips[1], narrow, wide)
        depth = center[:, 2] - tip
        columns = (center, flat, width, depth, self._quality[level])
        return rank_grasps(*(values[depth >= MIN_DEPTH] for values in columns))

    def _for_cup(self, matrix: Floats, _view: View, _gripper: Gripper) -> list[Grasp]:
        cosine = -vectors(self._free, "approach") @ matrix[2, :3]
        down = np.flatnonzero((cosine >= np.cos(CUP_TILT)) & (self._quality > 0))
        center = self._center[down] @ matrix[:3, :3].T + matrix[:3, 3]
        axis, width = np.tile([1.0, 0.0], (len(down), 1)), np.zeros(len(down))
        depth = np.clip(center[:, 2], 0.0, SEARCH)
        return rank_grasps(center, axis, width, depth, self._quality[down] * cosine[down])


def grasps_if_any(
    mesh: trimesh.Trimesh, object_id: str, parameters: LabelParameters
) -> pd.DataFrame:
    """Like `dataset_grasps`, but if there are none, an empty table and a line in the log."""
    try:
        return dataset_grasps(mesh, object_id, parameters)
    except RejectedError as reason:
        log.info("%s has no grasps: %s", object_id, reason)
        return empty(GRASPS)

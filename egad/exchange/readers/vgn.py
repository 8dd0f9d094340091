"""Grasps of VGN: the CSV file `grasps.csv` of its data generation.

Source: Breyer et al., CoRL 2020, and the code of the authors (ethz-asl/vgn: `io.py` writes the
file, `simulation.py` has the hand).
"""

import numpy as np

from egad.exchange.grasp_files import (
    Content,
    FileGrasps,
    ReadOptions,
    file_grasps,
    hand_in_frame,
    one_object,
    quaternion_poses,
)

POINT, TURN = ("x", "y", "z"), ("qx", "qy", "qz", "qw")
NUMBERS = (*POINT, *TURN, "width", "label")
KEYS = ({"scene_id", *NUMBERS},)
REFERENCE = "its poses are in the frame of a scene, the workspace of VGN"
TIPS = 0.05  # metres from its poses to the fingertips of its Panda, `finger_depth`


def read(content: Content, options: ReadOptions) -> FileGrasps:
    """The grasps of one scene. `width` is what closed fingers measured, if the grasp succeeded."""
    scenes = content["scene_id"].astype(str)
    rows = scenes == one_object(scenes.tolist(), options, "scenes")
    columns = {name: content[name][rows].astype(np.float64) for name in NUMBERS}
    points, turns = (np.stack([columns[n] for n in names], 1) for names in (POINT, TURN))
    return file_grasps(
        quaternion_poses(points, turns),
        hand_in_frame(options.frame or "y z", options.depth_or(TIPS, "the file")),
        widths=np.where(columns["label"] == 1, columns["width"], np.nan),
        success=columns["label"],
    )

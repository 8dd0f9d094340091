"""Grasps of VGN: the CSV file `grasps.csv` of its data generation.

Source: Breyer et al., CoRL 2020, and the code of the authors (ethz-asl/vgn: `io.py` writes the
file, `simulation.py` has the hand).
"""

import numpy as np

from egad.exchange import grasp_files as files

POINT, TURN = ("x", "y", "z"), ("qx", "qy", "qz", "qw")
NUMBERS = (*POINT, *TURN, "width", "label")
KEYS = ({"scene_id", *NUMBERS},)
REFERENCE = "its poses are in the frame of a scene, the workspace of VGN"
TIPS = 0.05  # metres from its poses to the fingertips of its Panda, `finger_depth`


def read(content: files.Content, options: files.ReadOptions) -> files.FileGrasps:
    """The grasps of one scene. `width` is what closed fingers measured, if the grasp succeeded."""
    options.needed("reference", REFERENCE)
    scenes = content["scene_id"].astype(str)
    rows = scenes == files.one_object(scenes.tolist(), options, "scenes")
    columns = {name: content[name][rows].astype(np.float64) for name in NUMBERS}
    points, turns = (np.stack([columns[n] for n in names], 1) for names in (POINT, TURN))
    return files.file_grasps(
        files.quaternion_poses(points, turns),
        files.hand_in_frame(options.frame or "y z", options.depth_or(TIPS, "the file")),
        widths=np.where(columns["label"] == 1, columns["width"], np.nan),
        success=columns["label"],
    )

"""Plain poses: `poses` (n, 4, 4) of an NPZ or NPY file, or a CSV file with quaternions.

An NPZ file may have `widths`, `success` and `score`, (n,). The columns of a CSV file are `x`, `y`,
`z`, `qx`, `qy`, `qz`, `qw`, and optionally `width`, `success` and `score`.
"""

import numpy as np

from egad.exchange.grasp_files import (
    UNITS,
    Content,
    FileGrasps,
    ReadOptions,
    file_grasps,
    hand_in_frame,
    quaternion_poses,
)

POINT, TURN = ("x", "y", "z"), ("qx", "qy", "qz", "qw")
KEYS = ({"poses"}, {*POINT, *TURN})
REFERENCE = ""  # that of the mesh, unless the caller says otherwise


def read(content: Content, options: ReadOptions) -> FileGrasps:
    """All grasps; their frame, depth and unit must be told."""
    frame = options.needed("frame", "plain poses do not say which frame they are of")
    depth = options.needed("depth", "plain poses do not say where the contacts are")
    unit = UNITS[options.needed("units", "plain poses do not say in which unit they are")]
    columns = {
        name: content[key]
        for name, keys in {"widths": ("widths", "width"), "success": ("success",)}.items()
        for key in keys
        if key in content
    }
    if "widths" in columns:
        columns["widths"] = unit * np.asarray(columns["widths"], np.float64)
    if score := [key for key in ("score", "scores") if key in content]:
        columns["score"] = content[score[0]]
    matrices = np.array(_matrices(content), dtype=np.float64)
    if matrices.ndim == 3 and matrices.shape[1:] == (4, 4):
        matrices[:, :3, 3] *= unit
    return file_grasps(matrices, hand_in_frame(frame, depth), **columns)


def _matrices(content: Content) -> object:
    if "poses" in content:
        return content["poses"]
    points, turns = (np.stack([content[name] for name in names], 1) for names in (POINT, TURN))
    return quaternion_poses(points, turns)

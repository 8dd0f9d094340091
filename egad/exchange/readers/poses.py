"""Plain poses: `poses` (n, 4, 4) of an NPZ or NPY file, or a CSV file with quaternions.

An NPZ file may have `widths`, `success` and `score`, (n,), and say `frame`, `depth` and `units`.
The columns of a CSV file are `x`, `y`, `z`, `qx`, `qy`, `qz`, `qw`, and optionally `width`,
`success` and `score`.
"""

import numpy as np

from egad.exchange import grasp_files as files

POINT, TURN = ("x", "y", "z"), ("qx", "qy", "qz", "qw")
KEYS = ({"poses"}, {*POINT, *TURN})


def read(content: files.Content, options: files.ReadOptions) -> files.FileGrasps:
    """All grasps; the file or the caller must say their frame, depth and unit."""
    for name in ("frame", "depth", "units"):
        if getattr(options, name) is None and np.ndim(content.get(name, [])) == 0:
            options = options._replace(**{name: content[name].item()})
    frame = options.needed("frame", "plain poses do not say which frame they are of")
    depth = options.needed("depth", "plain poses do not say where the contacts are")
    unit = files.UNITS[options.needed("units", "plain poses do not say in which unit they are")]
    widths, success, score = (
        np.asarray(next((content[key] for key in keys if key in content), np.nan), np.float64)
        for keys in (("widths", "width"), ("success",), ("score", "scores"))
    )
    if "poses" in content:
        matrices = np.array(content["poses"], dtype=np.float64)
    else:
        columns = (np.stack([content[name] for name in names], 1) for names in (POINT, TURN))
        matrices = files.quaternion_poses(*columns)
    matrices[..., :3, 3:] *= unit
    place = files.hand_in_frame(frame, depth)
    return files.file_grasps(matrices, place, widths=unit * widths, success=success, score=score)

"""Predictions of Contact-GraspNet: an NPZ file with grasps in the frame of the camera.

Source: Sundermeyer et al., ICRA 2021, equations 1 to 3, and the code of the authors
(NVlabs/contact_graspnet: `inference.py` writes the file, `build_6d_grasp` the poses).
"""

import numpy as np

from egad.exchange import grasp_files as files

KEYS = ({"pred_grasps_cam", "scores"},)
REFERENCE = "its poses are in the frame of the camera (x right, y down, z forward)"
DEPTH = 0.1034  # metres from the base of the Panda's hand to the contacts


def read(content: files.Content, options: files.ReadOptions) -> files.FileGrasps:
    """The grasps of one segment; -1 stands for the whole cloud. Contacts give the widths."""
    options.needed("reference", REFERENCE)
    segments = {str(key): key for key in content["pred_grasps_cam"]}
    key = segments[files.one_object(list(segments), options, "segments")]
    matrices = np.asarray(content["pred_grasps_cam"][key], np.float64).reshape(-1, 4, 4)
    depth = DEPTH if options.depth is None else options.depth
    widths = np.full(len(matrices), np.nan)
    if "contact_pts" in content:
        contacts = np.asarray(content["contact_pts"][key], np.float64).reshape(-1, 3)
        middles = matrices[:, :3, 3] + DEPTH * matrices[:, :3, 2]
        widths = 2 * np.abs(np.einsum("nk,nk->n", middles - contacts, matrices[:, :3, 0]))
    place = files.hand_in_frame(options.frame or "x z", depth)
    return files.file_grasps(matrices, place, widths=widths, score=np.ravel(content["scores"][key]))

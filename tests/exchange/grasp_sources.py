"""Files of grasps as other programs write them, of an object that is neither round nor symmetric.

The files of ACRONYM, GraspGen and GraspNet are those of egad's writers, which their own readers
read; those of Contact-GraspNet, VGN and the Isaac files of GraspGen follow the lines of code that
are named beside each function.
"""

import csv
import json

import numpy as np
import pytest
import trimesh
import yaml
from scipy.spatial.transform import Rotation

from egad.exchange.grasps.acronym import AcronymObject, write_acronym
from egad.exchange.grasps.graspgen import graspgen_hand, start_graspgen, write_graspgen
from egad.exchange.grasps.graspnet import write_graspnet
from egad.exchange.parameters import NamedGripper
from egad.geometry import Bundle
from egad.grippers import gripper
from egad.sim import make_simulation_object
from egad.tables.grasping import MOTIONS

HAND = NamedGripper("panda", gripper("panda"))
CAMERA = np.eye(4)  # looks down at the object from 0.5 m above it, turned by 0.4 rad
CAMERA[:3, :3] = Rotation.from_euler("xz", [np.pi, 0.4]).as_matrix()
CAMERA[:3, 3] = 0.03, -0.02, 0.5


def hammer():
    """A head with a handle, 0.16 m long, away from the origin."""
    head = trimesh.creation.box((0.03, 0.08, 0.035))
    handle = trimesh.creation.box((0.13, 0.022, 0.016)).apply_translation((0.07, 0.01, 0.005))
    whole = trimesh.boolean.union([head, handle], engine="manifold")
    return whole.apply_transform(
        trimesh.transformations.rotation_matrix(0.6, (1, 2, 3), (0, 0, 0.1))
    )


def labelled(grasps):
    """The table of grasps with made-up simulated labels: every third one fails."""
    table = grasps.to_frame()
    held = np.arange(len(table)) % 3 > 0
    outcome = np.where(held, "success", "slipped_shaking")
    return table.assign(
        simulated_outcome=outcome, simulated_success=held, **dict.fromkeys(MOTIONS, 0.0)
    )


def acronym(folder, table):
    body = AcronymObject("hammer.obj", 1.0, 1e-4, 0.1, np.zeros(3), np.eye(3), 0.5)
    write_acronym(folder / "hammer.h5", body, HAND, table, 0.5)
    return folder / "hammer.h5"


def graspgen(folder, table):
    hand = graspgen_hand(*HAND)
    start_graspgen(folder, hand)
    write_graspgen(folder, hand, "hammer", table)
    return folder / "grasp_data/panda/hammer.json"


def graspnet(folder, table):
    write_graspnet(folder, "hammer", table, HAND.gripper.opening)
    return folder / "hammer.npy"


def contact_graspnet(folder, grasps):
    """As `inference.py`, with poses of `build_6d_grasp`, in the frame of `CAMERA`."""
    poses = np.linalg.inv(CAMERA) @ grasps.poses
    poses[:, :3, 3] -= 0.1034 * poses[:, :3, 2]
    points = grasps.contacts[:, 0] @ np.linalg.inv(CAMERA)[:3, :3].T + np.linalg.inv(CAMERA)[:3, 3]
    score = np.linspace(0.9, 0.2, len(poses))
    path = folder / "predictions_7.npz"
    np.savez(path, pred_grasps_cam={1: poses}, scores={1: score}, contact_pts={1: points})
    return path


def vgn(folder, grasps):
    """As `write_grasp` of `io.py`: y closes, z approaches, fingertips 50 mm ahead."""
    path = folder / "grasps.csv"
    with path.open("w", newline="") as file:
        write = csv.writer(file).writerow
        write(["scene_id", "qx", "qy", "qz", "qw", "x", "y", "z", "width", "label"])
        for number, (pose, width) in enumerate(zip(grasps.poses, grasps.widths, strict=True)):
            turn = Rotation.from_matrix(np.stack([-pose[:3, 1], pose[:3, 0], pose[:3, 2]], 1))
            point = pose[:3, 3] - (0.05 - 0.0105) * pose[:3, 2]
            label = int(number % 4 > 0)
            write(["4f", *turn.as_quat(), *point, width if label else 0.08, label])
    return path


def isaac(folder, grasps):
    """As `save_to_isaac_grasp_format` of GraspGen's `eval_utils.py`, in GraspGen's frame."""
    poses = grasps.poses
    poses[:, :3, 3] -= 0.10527314 * poses[:, :3, 2]
    listed = {}
    for number, pose in enumerate(poses):
        w, *xyz = Rotation.from_matrix(pose[:3, :3]).as_quat(scalar_first=True).tolist()
        listed[f"grasp_{number}"] = {
            "confidence": 0.5,
            "position": pose[:3, 3].tolist(),
            "orientation": {"w": w, "xyz": xyz},
        }
    path = folder / "grasps.yaml"
    content = {"format": "isaac_grasp", "format_version": 1.0, "grasps": listed}
    path.write_text(yaml.dump(content, sort_keys=False))
    return path


def plain(folder, grasps):
    """Poses of the contacts in millimetres, y along the closing axis and x along the approach."""
    poses = grasps.poses[:, :, [2, 0, 1, 3]]
    poses[:, :3, 3] *= 1000
    np.savez(folder / "plain.npz", poses=poses, widths=1000 * grasps.widths)
    return folder / "plain.npz"


def simready(folder, table):
    """A prop, of whose grasps all hold."""
    pytest.importorskip("pxr")
    from egad.exchange.grasps.simready import write  # noqa: PLC0415 (an extra)

    made = make_simulation_object(hammer(), 300, Bundle(), "hammer")
    rows = table.assign(simulated_success=True, simulated_engine="mujoco")
    write(folder, "hammer", made, rows, HAND)
    return folder / "hammer/simready/hammer.usd"


IDENTITY = np.eye(4)
# writer, whether it takes a table, what has to be said to read its file, largest error of poses
SOURCES = {
    "acronym": (acronym, True, {}, 1e-9),
    "graspgen": (graspgen, True, {}, 2e-9),
    "graspnet": (graspnet, True, {"reference": IDENTITY}, 1e-9),
    "contact_graspnet": (contact_graspnet, False, {"reference": CAMERA}, 1e-9),
    "vgn": (vgn, False, {"reference": IDENTITY}, 1e-9),
    "isaac_grasp": (isaac, False, {"frame": "x z", "depth": 0.10527314}, 1e-9),
    "simready": (simready, True, {}, 1e-6),
    "poses": (plain, False, {"frame": "y x", "depth": 0.0, "units": "mm"}, 1e-9),
}


def write_source(name, folder, grasps):
    """A file of a format with these grasps, and what has to be said to read it."""
    writer, takes_table, said, _ = SOURCES[name]
    folder.mkdir(exist_ok=True)
    return writer(folder, labelled(grasps) if takes_table else grasps), said


def change_json(path, change):
    """Rewrite a JSON file after a change of its content."""
    content = json.loads(path.read_text())
    change(content)
    path.write_text(json.dumps(content))

"""GraspGen datasets: JSON files of grasps, lists of objects to train on, and the gripper."""

import hashlib
import json
import logging
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
import pandas as pd
import trimesh
import yaml

from egad._util.arrays import Floats
from egad.exchange import grasp_files as files
from egad.exchange.grasp_tables import simulated_by_object
from egad.exchange.hdf5 import check_key
from egad.exchange.new_folder import new_folder
from egad.exchange.parameters import GripperFormat, NamedGripper
from egad.geometry import joined
from egad.grasps import Grasps
from egad.grippers import Gripper, JawBody, ModelBody, base_pose, finger_span, hand_body
from egad.io import write_obj
from egad.sim import SimulationObject, held_when_shaken, with_outcome

log = logging.getLogger(__name__)

KEYS = ({"grasps.transforms"},)
Split = Literal["train", "valid"]
SPLITS: tuple[Split, Split] = ("train", "valid")
ONE_IN = 10  # one in this many objects is for validation
MIN_POSITIVE = 5  # an object with fewer is left out by GraspGen's reader
# Depths of hands that GraspGen itself describes, metres, by our names for them.
DEPTHS = {"panda": 0.10527314, "robotiq_2f_140": 0.195}
# for `format`: what it is, and the name of its points
DESCRIPTION = '''\
"""A {kind} for GraspGen; the .py, .yaml and .obj files belong in config/grippers."""

from pathlib import Path

import numpy as np
import torch
import trimesh
from grasp_gen.robot import load_control_points_core, load_default_gripper_config

HERE = Path(__file__)
{points} = np.asarray(load_control_points_core(load_default_gripper_config(HERE.stem)))


class GripperModel:
    def __init__(self, data_root_dir=None):
        self.mesh = trimesh.load(HERE.with_suffix(".obj"), force="mesh")

    def get_gripper_collision_mesh(self):
        return self.mesh.copy()

    def get_gripper_visual_mesh(self):
        return self.mesh.copy()
'''
OF_HAND = """

def load_control_points():
    points = np.vstack([CORNERS, np.zeros(3)])
    return torch.from_numpy(np.column_stack([points, np.ones(len(points))]).T).float()


def load_control_points_for_visualization():
    right, left, right_tip, left_tip = CORNERS
    palm = (right + left) / 2
    return [[right_tip, right, palm, np.zeros(3), palm, left, left_tip]]
"""


class GraspGenHand(NamedTuple):
    """A hand in GraspGen's frame: z approaches, x closes; `depth` is from base to pads, metres."""

    name: str
    gripper: Gripper
    depth: float


def check(hand: NamedGripper) -> None:
    """Check that a gripper can be described; UserError if its file cannot be used."""
    graspgen_hand(hand.name, hand.gripper)


def graspgen_hand(name: str, gripper: Gripper) -> GraspGenHand:
    """A gripper with its depth: from its file, GraspGen's hand of that name, or the palm's back."""
    if (base := base_pose(gripper, 0.0)) is not None:
        return GraspGenHand(name, gripper, -float(base[2, 3]))
    back = gripper.palm[2] - finger_span(gripper)[0]
    return GraspGenHand(name, gripper, DEPTHS.get(name, back))


def graspgen_poses(hand: GraspGenHand, grasps: Grasps) -> Floats:
    """Poses of the base of a hand in the frame of the object, (n, 4, 4)."""
    return grasps.poses @ np.linalg.inv(pads_in_base(hand.gripper, hand.depth, grasps.widths))


def pads_in_base(gripper: Gripper, depth: float, widths: Floats) -> Floats:
    """Poses of the frame of n grasps in that of the base of a hand, (n, 4, 4), metres."""
    body = hand_body(gripper)
    poses = files.hand_in_frame("x z", depth + body.reach(widths))
    if isinstance(body, ModelBody):
        poses[:, 0, 3] = body.model.middle_at(widths)[:, 0]
    return poses


def read(content: files.Content, options: files.ReadOptions) -> files.FileGrasps:
    """The grasps of a file in the frame of its mesh times `object.scale`; ours have widths."""
    grasps, hand = content["grasps"], options.gripper
    matrices = np.asarray(grasps["transforms"], np.float64)
    widths = np.full(len(matrices), np.nan)
    if (contacts := grasps.get("contact_locations")) is not None:
        widths = np.linalg.norm(np.diff(np.reshape(contacts, (-1, 2, 3)), axis=1)[:, 0], axis=1)
    depths = options.depth, files.mapping(content.get("gripper", {}), "its gripper").get("depth")
    depth = next((each for each in depths if each is not None), None)
    if depth is None:
        named = options.needed("gripper", "the file has no depth of the hand (or give `depth`)")
        depth = graspgen_hand(*named).depth
    if hand is None or options.frame is not None:
        place = files.hand_in_frame(options.frame or "x z", depth)
    else:
        place = pads_in_base(hand.gripper, depth, np.nan_to_num(widths))
    success = np.asarray(grasps.get("object_in_gripper", np.nan), np.float64)
    return files.file_grasps(matrices, place, widths=widths, success=success)


def default_split(label: str) -> Split:
    """The list of an object: at random, one in ten is for validation, independent of the others."""
    number = int.from_bytes(hashlib.sha256(label.encode()).digest()[:8])
    return "train" if number % ONE_IN else "valid"


def write_graspgen(
    folder: Path, hand: GraspGenHand, label: str, grasps: pd.DataFrame, split: Split | None = None
) -> int:
    """Write the grasps of an object, and its name to a list; the number of successes.

    `object_in_gripper` is true for those that held. With fewer than `MIN_POSITIVE` successes
    GraspGen leaves the object out. `default_split` does not keep relatives together.
    """
    known = with_outcome(grasps)
    labelled, held = Grasps(known), held_when_shaken(known)
    written = {
        "object": {"file": f"{label}.obj", "scale": 1.0},
        "gripper": {"name": hand.name, "depth": hand.depth},
        "grasps": {
            "transforms": graspgen_poses(hand, labelled).round(9).tolist(),
            "object_in_gripper": held.tolist(),
            "contact_locations": labelled.contacts.round(9).tolist(),
        },
    }
    add_object(folder, hand.name, label, written, split)
    return int(held.sum())


def start_graspgen(folder: Path, hand: GraspGenHand) -> None:
    """Make the folders of a dataset, empty lists, and the description of the gripper."""
    about = {
        "width": hand.gripper.opening,
        "depth": hand.depth,
        "transform_offset_from_asset_to_graspgen_convention": [[0.0] * 3, [0.0] * 3 + [1.0]],
        "symmetric_antipodal": not isinstance(hand_body(hand.gripper), JawBody),
    }
    program = DESCRIPTION.format(kind="hand", points="CORNERS") + OF_HAND
    start_dataset(folder, hand.name, about, program, _mesh(hand))


def start_dataset(
    folder: Path, name: str, about: Mapping[str, Any], program: str, mesh: trimesh.Trimesh
) -> None:
    """Make the folders of a dataset, empty lists, and YAML, program and mesh (m) of a gripper."""
    for each in ("grasp_data", "splits"):
        (folder / each / name).mkdir(parents=True)
    (folder / "objects").mkdir()
    for split in SPLITS:
        (folder / "splits" / name / f"{split}.txt").touch()
    described = folder / "gripper"
    described.mkdir()
    (described / f"{name}.yaml").write_text(yaml.safe_dump(about, sort_keys=False))
    (described / f"{name}.py").write_text(program)
    write_obj(mesh, described / f"{name}.obj")


def add_object(
    folder: Path, name: str, label: str, written: Mapping[str, Any], split: Split | None = None
) -> None:
    """Write the file of an object, and its name to the list of a split."""
    (folder / "grasp_data" / name / f"{label}.json").write_text(json.dumps(written) + "\n")
    listed = folder / "splits" / name / f"{split or default_split(label)}.txt"
    listed.write_text(f"{listed.read_text()}{label}.obj\n")


def _mesh(hand: GraspGenHand) -> trimesh.Trimesh:
    body = hand_body(hand.gripper)
    if isinstance(body, ModelBody):
        links = body.model.points(hand.gripper.opening)
        shapes = [trimesh.convex.convex_hull(points) for link in links for points in link]
    else:
        shapes = [trimesh.creation.box(bounds=part.box) for part in body.parts()]
    mesh = joined(shapes)
    mesh.apply_translation([0, 0, hand.depth])
    return mesh


def write(
    folder: Path, label: str, made: SimulationObject, grasps: pd.DataFrame, hand: NamedGripper
) -> None:
    """Add an object to a dataset of GraspGen: see `egad.exchange.registry`."""
    theirs = graspgen_hand(hand.name, hand.gripper)
    if not (folder / "objects").exists():
        start_graspgen(folder, theirs)
    write_obj(made.mesh, folder / "objects" / f"{label}.obj")
    write_graspgen(folder, theirs, label, grasps)


def run(
    settings: GripperFormat, gripper: str, meshes: Path, simulated_grasps: Path, out: Path
) -> None:
    """Write a dataset of GraspGen: grasps, meshes, lists of objects and the gripper."""
    with new_folder(out) as folder:
        hand = graspgen_hand(check_key(gripper, "gripper"), settings.gripper)
        start_graspgen(folder, hand)
        for label, rows in simulated_by_object(simulated_grasps):
            name = f"{check_key(label)}.obj"
            shutil.copyfile(meshes / name, folder / "objects" / name)
            held = write_graspgen(folder, hand, label, rows)
            if held < MIN_POSITIVE:
                log.warning(
                    "%s has %d grasps that hold; GraspGen leaves out objects with fewer than %d",
                    label,
                    held,
                    MIN_POSITIVE,
                )

"""isaac_grasp files: the grasps of a gripper on an object, for Isaac Sim and Isaac ROS."""

from pathlib import Path

import numpy as np
import pandas as pd
import yaml
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from egad.errors import UserError
from egad.exchange import grasp_files as files
from egad.exchange.grasp_tables import simulated_by_object
from egad.exchange.hdf5 import check_key
from egad.exchange.new_folder import new_folder
from egad.exchange.parameters import GripperFormat, NamedGripper
from egad.grasps import Grasps
from egad.grippers import Gripper, base_link, base_pose, hand_body, joint_values, model_of
from egad.io import write_obj
from egad.sim import SimulationObject, held_when_shaken, with_outcome

KEYS = ({"format", "grasps"},)
DECIMALS = 9
WIDE = 1000  # characters of a line


def check(hand: NamedGripper) -> None:
    """Check that a gripper has joints; UserError if it is made of boxes."""
    if hand.gripper.file is None:
        raise UserError(
            f"gripper {hand.name!r} is made of boxes, but isaac_grasp files have positions of "
            "joints: give its URDF or MJCF file, as `file:` in the configuration or with "
            "egad.Gripper.from_file"
        )


def write_isaac_grasp(path: Path, label: str, gripper: Gripper, grasps: pd.DataFrame) -> None:
    """Write the grasps on an object; frames are its scaled mesh and the base link of the gripper.

    The confidence is 1 if both fingers still held the object after it was shaken in simulation,
    and 0 for the others and for grasps at which the open hand collides. Grasps with no known
    outcome are left out. In `cspace_position`, the fingers stand beside the object, at the needed
    opening; a fixed jaw and the jaw that faces it stand `JAW_CLEARANCE` farther out.

    Source: version 1.0 as the documentation of Isaac Sim and Isaac ROS describes it. They name the
    frames differently; both names are written.
    """
    known = with_outcome(grasps)
    widths = Grasps(known).widths
    aside = hand_body(gripper).aside(widths, widths)
    bases = np.reshape([base_pose(gripper, width) for width in widths], (-1, 4, 4))
    bases[:, 0, 3] += aside
    poses = Grasps(known).poses @ bases
    turns = Rotation.from_matrix(poses[:, :3, :3]).as_quat(canonical=True)
    openings = known["needed_opening"] - 2 * aside
    base, opened = base_link(gripper), joint_values(gripper, gripper.opening)
    listed = {
        f"grasp_{number}": {
            "confidence": float(held),
            "position": _rounded(pose[:3, 3]),
            "orientation": {"w": _rounded(turn)[3], "xyz": _rounded(turn)[:3]},
            "cspace_position": joint_values(gripper, opening),
            "pregrasp_cspace_position": dict(opened),
        }
        for number, (held, pose, turn, opening) in enumerate(
            zip(held_when_shaken(known), poses, turns, openings, strict=True)
        )
    }
    frames = {"object_frame": label, "gripper_frame": base}
    frames |= {f"{name}_link": value for name, value in frames.items()}
    about = {"format": "isaac_grasp", "format_version": 1.0, **frames, "grasps": listed}
    path.write_text(yaml.safe_dump(about, sort_keys=False, default_flow_style=None, width=WIDE))


def read(content: files.Content, options: files.ReadOptions) -> files.FileGrasps:
    """The grasps of a file; with a gripper that has a file, of its base link.

    The pads are where `cspace_position` puts them. A hand of boxes has no base link, so frame and
    depth must be told: GraspGen writes such files in its own frame.
    """
    grasps = list(content["grasps"].values())
    turns = [[*each["orientation"]["xyz"], each["orientation"]["w"]] for each in grasps]
    points = np.reshape([each["position"] for each in grasps], (-1, 3))
    hand, openings = options.gripper and options.gripper.gripper, np.full(len(grasps), np.nan)
    if hand is not None and hand.file is not None and options.frame is None:
        model, joints = model_of(hand), [each.get("cspace_position", {}) for each in grasps]
        positions = [each.get(model.joints[0], np.nan) for each in joints]
        openings = np.array([model.opening_at(each) for each in positions])
        known = np.where(np.isnan(openings), hand.opening, openings)
        place = np.linalg.inv(np.array([base_pose(hand, each) for each in known], np.float64))
    else:
        why = "the frame of a hand is not in the file, and the gripper has no file of its own"
        place = files.hand_in_frame(options.needed("frame", why), options.needed("depth", why))
    matrices = files.quaternion_poses(points, np.array(turns))
    score = [each.get("confidence", np.nan) for each in grasps]
    return files.file_grasps(matrices, place, openings=openings, score=score)


def _rounded(numbers: NDArray[np.float64]) -> list[float]:
    rounded: list[float] = numbers.round(DECIMALS).tolist()
    return rounded


def write(
    folder: Path, label: str, made: SimulationObject, grasps: pd.DataFrame, hand: NamedGripper
) -> None:
    """Write `LABEL.yaml`, and `meshes/LABEL.obj`: see `egad.exchange.registry`."""
    write_isaac_grasp(folder / f"{label}.yaml", label, hand.gripper, grasps)
    write_obj(made.mesh, folder / f"meshes/{label}.obj")


def run(settings: GripperFormat, simulated_grasps: Path, out: Path) -> None:
    """Write a file for each object that has grasps, in the frame of its scaled mesh."""
    with new_folder(out) as folder:
        for label, rows in simulated_by_object(simulated_grasps):
            path = folder / f"{check_key(label)}.yaml"
            write_isaac_grasp(path, label, settings.gripper, rows)

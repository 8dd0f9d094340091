"""isaac_grasp files: the grasps of a gripper on an object, for Isaac Sim and Isaac ROS."""

from pathlib import Path

import numpy as np
import pandas as pd
import yaml
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from egad.errors import UserError
from egad.grasps import Grasps, held_when_shaken, with_outcome
from egad.grippers import Gripper, base_link, base_pose, joint_values

DECIMALS = 9
WIDE = 1000  # characters of a line


def check_articulated(name: str, gripper: Gripper) -> None:
    """Check that a gripper has joints.

    Args:
        name: Of the gripper.
        gripper: Its settings.

    Raises:
        UserError: It is made of boxes; the text says what to give.
    """
    if gripper.file is None:
        raise UserError(
            f"gripper {name!r} is made of boxes, but isaac_grasp files have positions of joints: "
            "give its URDF or MJCF file, as `file:` in the configuration or with "
            "egad.Gripper.from_file"
        )


def write_isaac_grasp(path: Path, label: str, gripper: Gripper, grasps: pd.DataFrame) -> None:
    """Write the grasps on an object.

    The confidence is 1 if both fingers still held the object after it was shaken in simulation,
    and 0 for the others and for grasps at which the open hand collides. Grasps of which nothing is
    known are left out.

    Args:
        path: A name that ends in `.yaml`.
        label: Of the object; its frame is that of its mesh, scaled.
        gripper: With a file; the frame of the gripper is that of its base link.
        grasps: One row per grasp, with the columns of `tables.grasping.SIMULATED_GRASPS`.

    Source: version 1.0 as the documentation of Isaac Sim and Isaac ROS describes it. They name the
    frames differently; both names are written.
    """
    known = with_outcome(grasps)
    widths = Grasps(known).widths
    bases = np.array([base_pose(gripper, width) for width in widths]).reshape(-1, 4, 4)
    poses = Grasps(known).poses @ bases
    turns = Rotation.from_matrix(poses[:, :3, :3]).as_quat(canonical=True)
    base, opened = base_link(gripper), joint_values(gripper, gripper.opening)
    listed = {
        f"grasp_{number}": {
            "confidence": float(held),
            "position": _rounded(pose[:3, 3]),
            "orientation": {"w": _rounded(turn)[3], "xyz": _rounded(turn)[:3]},
            "cspace_position": joint_values(gripper, width),
            "pregrasp_cspace_position": dict(opened),
        }
        for number, (held, pose, turn, width) in enumerate(
            zip(held_when_shaken(known), poses, turns, widths, strict=True)
        )
    }
    frames = {"object_frame": label, "gripper_frame": base}
    frames |= {f"{name}_link": value for name, value in frames.items()}
    about = {"format": "isaac_grasp", "format_version": 1.0, **frames, "grasps": listed}
    path.write_text(yaml.safe_dump(about, sort_keys=False, default_flow_style=None, width=WIDE))


def _rounded(numbers: NDArray[np.float64]) -> list[float]:
    rounded: list[float] = numbers.round(DECIMALS).tolist()
    return rounded

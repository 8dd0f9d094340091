"""Files, joints and base link of a gripper, for programs that load its description themselves."""

from pathlib import Path

import numpy as np

from egad._util.arrays import Floats
from egad.errors import UserError
from egad.grippers.described import description_files, read_described
from egad.grippers.model import GripperModel
from egad.grippers.parameters import Gripper


def model_of(gripper: Gripper) -> GripperModel:
    """The model of a gripper that has a file.

    Raises:
        UserError: It has none, the file cannot be used, or MuJoCo is not installed.
    """
    if gripper.file is None:
        raise UserError("this gripper has no file that describes it")
    return read_described(Path(gripper.file), gripper.model_dump())


def files_of(gripper: Gripper) -> list[Path]:
    """The files that a gripper is read from: its description with all meshes, or its palm mesh.

    Raises:
        UserError: The description or one of its meshes cannot be used.
    """
    if gripper.file is None:
        return [Path(gripper.mesh)] if gripper.mesh else []
    return description_files(Path(gripper.file))


def joint_values(gripper: Gripper, opening: float) -> dict[str, float]:
    """Positions of the driven joints in the file of a gripper, at an opening.

    Joints that follow others (mimic joints, linkages) are left out. Two fingers without a common
    drive have a joint each.

    Args:
        gripper: The gripper.
        opening: Distance between the pads, metres; the nearest one that the hand has is used.

    Returns:
        Metres or radians, by the names of the joints; empty for a gripper without a file.

    Raises:
        UserError: Its file cannot be used.
    """
    if (model := _model(gripper)) is None:
        return {}
    positions = model.joint_positions(opening)
    return {name: positions[name] for name in model.joints[: model.n_driven]}


def base_link(gripper: Gripper) -> str | None:
    """Name of the link in the file of a gripper that carries its fingers; None without a file.

    Raises:
        UserError: Its file cannot be used.
    """
    model = _model(gripper)
    return None if model is None else model.links[0].name


def base_pose(gripper: Gripper, opening: float) -> Floats | None:
    """Pose of the base link in the frame of a grasp, (4, 4), metres; None without a file.

    The frame of a grasp has its origin midway between the pads, x along the closing axis and z
    along the approach. While the hand closes, the midpoint of the pads of a linkage moves along z,
    and that of a hand with one moving jaw along x, so the pose depends on the opening. At the
    opening that the object leaves, the pads meet the contacts of the grasp.

    Args:
        gripper: The gripper.
        opening: Distance between the pads, metres; the nearest one that the hand has is used.

    Raises:
        UserError: Its file cannot be used.
    """
    if (model := _model(gripper)) is None:
        return None
    pose = np.linalg.inv(model.palm_to_hand)
    pose[:3, 3] -= model.middle_at(np.array(opening))
    return np.asarray(pose)


def _model(gripper: Gripper) -> GripperModel | None:
    return None if gripper.file is None else model_of(gripper)

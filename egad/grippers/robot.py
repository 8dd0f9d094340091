"""Files, joints, base link and tool center point of a gripper, for other programs."""

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from egad._util.arrays import Floats
from egad._util.extras import needed_for
from egad.errors import UserError, check_name
from egad.grippers.described import FILE, read_described
from egad.grippers.model import HandModel
from egad.grippers.parameters import Gripper


def model_of(gripper: Gripper) -> HandModel:
    """The model of a gripper with a file; `UserError` without one, or if it cannot be used."""
    if gripper.file is None:
        raise UserError("this gripper has no file that describes it")
    return read_described(Path(gripper.file), gripper.model_dump())


def files_of(gripper: Gripper) -> list[Path]:
    """The files a gripper is read from: description and meshes, or palm mesh; or `UserError`."""
    if gripper.file is None:
        return [Path(gripper.mesh)] if gripper.mesh else []
    with needed_for(FILE):
        from egad.grippers.description import description_files  # noqa: PLC0415 (an extra)
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
    if gripper.file is None:
        return {}
    model = model_of(gripper)
    positions = model.joint_positions(opening)
    return {name: positions[name] for name in model.joints[: model.n_driven]}


def joint_limits(path: Path) -> dict[str, tuple[float, float]]:
    """Limits of all joints in the file of a hand by name, metres or radians."""
    with needed_for(FILE):
        from egad.grippers.description import compile_skeleton, read_description  # noqa: PLC0415
    bare = compile_skeleton(read_description(path))
    ends = bare.jnt_range.tolist()
    return {str(bare.joint(number).name): (low, high) for number, (low, high) in enumerate(ends)}


def base_link(gripper: Gripper) -> str | None:
    """Name of the link in the file of a gripper that carries its fingers; None without a file."""
    return None if gripper.file is None else model_of(gripper).links[0].name


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
    if gripper.file is None:
        return None
    model = model_of(gripper)
    pose = np.linalg.inv(model.palm_to_hand)
    pose[:3, 3] -= model.middle_at(np.array(opening))
    return np.asarray(pose)


# x along the jaws, z from the fixed jaw to the moving one, seen from the frame of a grasp
ALONG_JAWS = np.array([[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]])


_SO101_AXES = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
# Sites named `gripperframe` on the link `gripper` of an SO-101: origin, metres, and axes in columns
SO101_FRAMES = {
    "gripperframe": ((-0.0079, -0.000218121, -0.0981274), _SO101_AXES),
    "menagerie": ((0.012, -0.000218, -0.098127), _SO101_AXES),
}
CONVENTIONS = ("fixed_jaw", "midpoint", *SO101_FRAMES)


def tcp_poses(gripper: Gripper, poses: ArrayLike, widths: ArrayLike, convention: str) -> Floats:
    """Poses of the tool center point of a hand with one moving jaw at n grasps: (n, 4, 4).

    `fixed_jaw` is on the face of the fixed jaw, at the pads; x points out along the jaws, z from
    the fixed to the moving one. `gripperframe` is the same on an SO-101, as TheRobotStudio, LeRobot
    and SO101-Nexus define it, and `menagerie` lies 20 mm in front of that face, as in MuJoCo
    Menagerie. `midpoint` is midway between the pads at the width of the grasp, with the axes of the
    link with the fixed jaw, as in ManiSkill.

    Args:
        gripper: The hand, with its file. For `gripperframe` and `menagerie`, an SO-101 whose palm
            has the frame of the maker's link `gripper`.
        poses: (n, 4, 4) of `egad.grasps.Grasps.poses`.
        widths: (n,) distances of the contacts, metres.
        convention: Name of the convention.

    Raises:
        UserError: There is no such convention, the shapes do not fit, or both jaws of the hand
            move.
    """
    check_name("convention", convention, CONVENTIONS)
    if model_of(gripper).lever is None:
        raise UserError("both fingers of this gripper move: it has no fixed jaw")
    given, apart = np.asarray(poses, float), np.asarray(widths, float)
    if apart.ndim != 1 or given.shape != (len(apart), 4, 4):
        raise UserError(
            "poses must have the shape (n, 4, 4) and widths (n,); "
            f"got {given.shape} and {apart.shape}"
        )
    frames = [
        pose @ _frame(gripper, float(width), convention)
        for pose, width in zip(given, apart, strict=True)
    ]
    return np.array(frames).reshape(-1, 4, 4)


def _frame(gripper: Gripper, width: float, convention: str) -> Floats:
    """Pose of the TCP in the frame of a grasp."""
    pose = np.eye(4)
    if convention == "fixed_jaw":
        pose[:3, :3], pose[0, 3] = ALONG_JAWS, -width / 2
        return pose
    base = base_pose(gripper, width)
    assert base is not None  # noqa: S101 (it has a model)
    if convention == "midpoint":
        pose[:3, :3] = base[:3, :3]
        return pose
    origin, axes = SO101_FRAMES[convention]
    pose[:3, :3], pose[:3, 3] = axes, origin
    return np.asarray(base @ pose)

"""The hand that fingertips are for: its links, joints and limits, from a file or from boxes."""

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from egad._util.arrays import Floats
from egad.errors import UserError
from egad.grippers import Gripper, HandModel, finger_span, joint_limits, model_of


class Base(NamedTuple):
    """A hand without its fingertips."""

    gripper: Gripper
    model: HandModel
    limits: dict[str, tuple[float, float]]  # of its joints by name, metres or radians

    @property
    def turns(self) -> bool:
        """Whether one jaw turns, so that the jaws are parallel at one opening only."""
        return self.model.lever is not None and self.model.joint_kind == "revolute"


def pose_of(model: HandModel, link: int, opening: float) -> Floats:
    """Pose of a link in the frame of the hand at an opening between tabulated ones, (4, 4)."""
    turns, places = model.poses(opening)
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = Rotation.from_matrix(turns[link]).as_matrix(), places[link]
    return pose


def base_of(name: str, gripper: Gripper) -> Base:
    """The hand that tips are designed for; `UserError` for a cup, or joints out of proportion."""
    if not gripper.kind.closes:
        raise UserError(
            f"the hand {name} has {gripper.kind.noun} and no jaws; fingertips need two jaws"
        )
    if gripper.file is None:
        return _base_of_boxes(gripper)
    model = model_of(gripper)
    if gripper.opening < model.openings[-1] - 1e-5:
        raise UserError(
            f"the hand {name} is set to open {1000 * gripper.opening:.1f} of "
            f"{1000 * model.openings[-1]:.1f} mm; fingertips are for all that its joint allows"
        )
    driven = (model.positions[:, 0] - model.positions[0, 0]) / np.ptp(model.positions[:, 0])
    for joint, column in zip(model.joints[1:], model.positions.T[1:], strict=True):
        line = column[0] + (column[-1] - column[0]) * driven / driven[-1]
        if np.abs(column - line).max() > 1e-3 * max(float(np.ptp(column)), 1e-3):
            raise UserError(
                f"the hand {name}: its joint {joint} does not follow {model.joints[0]} in "
                "proportion, as in a linkage; fingertips are for jaws that slide, or one that turns"
            )
    return Base(gripper, model, joint_limits(Path(gripper.file)))


def _base_of_boxes(gripper: Gripper) -> Base:
    """A hand that is three boxes, described as a file whose two fingers slide."""
    root, tip = finger_span(gripper)
    x, y, z = gripper.palm
    thick, wide, half = gripper.finger_thickness, gripper.finger_width, gripper.opening / 2

    box = '<link name="{}"><collision><origin xyz="{} 0 {}"/><geometry><box size="{} {} {}"/>'
    box += "</geometry></collision></link>"
    text = box.format("palm", 0, root - z / 2, x, y, z)
    for name, way, mimic in (("first", -1, ""), ("second", 1, '<mimic joint="first_joint"/>')):
        text += box.format(name, way * thick / 2, (root + tip) / 2, thick, wide, tip - root) + (
            f'<joint name="{name}_joint" type="prismatic"><parent link="palm"/>'
            f'<child link="{name}"/><axis xyz="{way} 0 0"/>{mimic}'
            f'<limit lower="0" upper="{half}" effort="10" velocity="1"/></joint>'
        )
    with TemporaryDirectory() as folder:
        path = Path(folder) / "boxes.urdf"
        path.write_text(f'<robot name="boxes">{text}</robot>')
        model, limits = model_of(Gripper.from_file(path)), joint_limits(path)
    return Base(gripper, model, limits)

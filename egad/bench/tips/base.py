"""The hand that fingertips are for: its links, joints and limits, from a file or from boxes."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from egad._util.arrays import Floats
from egad.errors import UserError
from egad.grippers import (
    FIRST_FINGER,
    PALM_BODY,
    SECOND_FINGER,
    Gripper,
    HandLink,
    HandModel,
    LinkJoint,
    finger_span,
    joint_limits,
    model_of,
)

CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
MASSES = (0.3, 0.03)  # kilograms, of the palm and a finger of a hand that is boxes


class Base(NamedTuple):
    """A hand without its fingertips."""

    gripper: Gripper
    model: HandModel
    limits: dict[str, tuple[float, float]]  # of its joints by name, metres or radians

    @property
    def turns(self) -> bool:
        """Whether one jaw turns, so that the jaws are parallel at one opening only."""
        return self.model.lever is not None and self.model.joint_kind == "revolute"

    def pose(self, link: int, opening: float) -> Floats:
        """Pose of a link in the frame of the hand at an opening, (4, 4), metres."""
        return pose_of(self.model, link, opening)


def pose_of(model: HandModel, link: int, opening: float) -> Floats:
    """Pose of a link in the frame of the hand at an opening between tabulated ones, (4, 4)."""
    turns, places = model.poses(opening)
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = Rotation.from_matrix(turns[link]).as_matrix(), places[link]
    return pose


def base_of(name: str, gripper: Gripper) -> Base:
    """The hand that tips are designed for.

    Args:
        name: What it is called in messages.
        gripper: A hand with two jaws, from a file or as boxes.

    Raises:
        UserError: It is a suction cup, has a palm mesh, or its joints do not move in proportion,
            as in a linkage.
    """
    if not gripper.kind.closes:
        raise UserError(
            f"the hand {name} has {gripper.kind.noun} and no jaws; fingertips need two jaws"
        )
    if gripper.file is None:
        half = gripper.opening / 2
        model = _box_model(gripper)
        return Base(gripper, model, dict.fromkeys(model.joints, (0.0, half)))
    model = model_of(gripper)
    limits = joint_limits(Path(gripper.file))
    driven = model.positions[:, 0] - model.positions[0, 0]
    for joint, column in zip(model.joints[1:], model.positions.T[1:], strict=True):
        line = column[0] + (column[-1] - column[0]) * driven / driven[-1]
        if np.abs(column - line).max() > 1e-3 * max(float(np.ptp(column)), 1e-3):
            raise UserError(
                f"the hand {name}: its joint {joint} does not follow {model.joints[0]} in "
                "proportion, as in a linkage; fingertips are for jaws that slide, or one that turns"
            )
    return Base(gripper, model, limits)


def _box_model(gripper: Gripper) -> HandModel:
    """The model of a hand that is three boxes, whose fingers slide."""
    root, tip = finger_span(gripper)
    width, thick, half = gripper.finger_width, gripper.finger_thickness, gripper.opening / 2
    x, y, z = gripper.palm
    names = ("first_finger", "second_finger")
    links = [_box("palm", PALM_BODY, [-x / 2, -y / 2, root - z], [x / 2, y / 2, root])]
    for name, body in zip(names, (FIRST_FINGER, SECOND_FINGER), strict=True):
        ends = sorted((0.0, body * thick))
        low, high = [ends[0], -width / 2, root], [ends[1], width / 2, tip]
        joint = LinkJoint(f"{name}_joint", "prismatic", np.array([body, 0, 0]), np.zeros(3), 0.0)
        links.append(_box(name, body, low, high)._replace(joint=joint, carrier=0))
    places = np.zeros((2, 3, 3))
    places[1, 1:, 0] = -half, half
    pad = np.array([[0, -width / 2, -tip], [0, width / 2, tip]])
    return HandModel(
        links=tuple(links),
        openings=np.array([0.0, gripper.opening]),
        reach=np.zeros(2),
        aside=np.zeros(2),
        angles=np.zeros(2),
        turns=np.tile(np.eye(3), (2, 3, 1, 1)),
        places=places,
        joints=tuple(f"{name}_joint" for name in names),
        n_driven=1,
        positions=np.array([[0.0, 0.0], [half, half]]),
        palm_to_hand=np.eye(4),
        pad=pad,
    )


def _box(name: str, body: int, low: list[float], high: list[float]) -> HandLink:
    """A link that is a box."""
    corners = np.array(low) + CORNERS * (np.array(high) - low)
    mass = MASSES[0] if body == PALM_BODY else MASSES[1]
    return HandLink(name, body, (corners,), mass, -1, np.eye(4), None)

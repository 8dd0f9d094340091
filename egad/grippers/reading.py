"""Reading a hand from the URDF or MJCF file that its maker publishes."""

import logging
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import mujoco
import numpy as np
from pydantic import TypeAdapter

from egad._util.arrays import Floats
from egad._util.parameters import Place
from egad.errors import UserError
from egad.grippers.description import (
    compile_skeleton,
    compile_with_shapes,
    mesh_files,
    name_file_in_messages,
    read_description,
    shapes_of,
)
from egad.grippers.fingers import Sides, find_driven, find_sides, snapped
from egad.grippers.links import hand_link
from egad.grippers.mechanism import Mechanism
from egad.grippers.model import GripperModel
from egad.grippers.stroke import Stroke, find_stroke
from egad.grippers.tree import find_palm, hand_bodies, joint_name, moving_joints, subtree

log = logging.getLogger(__name__)

SHORT = 5e-4  # metres or of a unit vector: shorter vectors have no direction
UPRIGHT = 20.0  # degrees; an approach this near to an axis of the palm is meant to be that


class Choices(NamedTuple):
    """What is not left to be found in a description: settings of `Gripper` of the same names.

    Attributes:
        joint: Name of the joint that closes the hand.
        finger_links: Names of a link of each finger.
        pad_links: Names of the links with the pads.
        tcp: Middle of the closed pads in the frame of the palm, metres.
        closing_axis: Axis along which the fingers close, in the frame of the palm.
        approach_axis: Axis along which the hand approaches, in the frame of the palm.
    """

    joint: str | None = None
    finger_links: tuple[str, str] | None = None
    pad_links: tuple[str, str] | None = None
    tcp: Place | None = None
    closing_axis: Place | None = None
    approach_axis: Place | None = None


def read_model(path: Path, choices: Choices = Choices()) -> GripperModel:  # noqa: B008 (a tuple)
    """The hand that a URDF or MJCF file describes.

    Args:
        path: The file.
        choices: What is not left to be found.

    Raises:
        UserError: The file cannot be used, or it is no parallel-jaw hand; with the link or joint.
    """
    changed = path.stat().st_mtime_ns if path.is_file() else 0
    with name_file_in_messages(path):
        meshes = mesh_files(_description(path, changed), path)
    return _read_model(path, choices, changed, tuple((m, m.stat().st_mtime_ns) for m in meshes))


@cache
def _description(path: Path, changed: int) -> mujoco.MjSpec:
    """What the file says; it is read again when it has `changed`."""
    del changed
    return read_description(path)


@cache
def _read_model(
    path: Path, choices: Choices, changed: int, meshes: tuple[tuple[Path, int], ...]
) -> GripperModel:
    """The same; the files are read again when one of them, or of its `meshes`, has `changed`."""
    del meshes
    with name_file_in_messages(path):
        model, beyond = _modelled(_description(path, changed).copy(), path, choices)
    if beyond:
        log.warning(
            "%s: joints that follow others go beyond their own limits, which do not count: %s",
            path,
            ", ".join(beyond),
        )
    return model


def choices_of(values: Mapping[str, Any]) -> Choices:
    """The choices among the settings of a gripper."""
    given = {name: values.get(name) for name in Choices._fields}
    parsed: Choices = TypeAdapter(Choices).validate_python(given)
    return parsed


def _modelled(spec: mujoco.MjSpec, path: Path, choices: Choices) -> tuple[GripperModel, list[str]]:
    """The model of a hand, and the joints that go beyond their own limits."""
    bare = compile_skeleton(spec)
    palm, chains = find_palm(bare, choices.finger_links)
    carried = set().union(*(subtree(bare, chain) for chain in chains))
    joints = [joint for joint in moving_joints(bare) if int(bare.jnt_bodyid[joint]) in carried]
    driven = find_driven(bare, joints, choices.joint)
    followers = [each for each in joints if each not in driven]
    description = compile_with_shapes(spec, path, hand_bodies(bare, palm))
    mechanism = Mechanism(description, palm, driven, followers)
    sides = find_sides(mechanism, chains)
    if choices.closing_axis is not None:
        sides = _along(sides, np.array(choices.closing_axis))
    stroke = find_stroke(mechanism, sides, choices.pad_links)
    model = _tabulated(mechanism, sides, stroke, _frame(mechanism, sides, stroke, choices))
    return model, mechanism.joints_beyond_limits(stroke.positions)


def _tabulated(
    mechanism: Mechanism, sides: Sides, stroke: Stroke, palm_to_hand: Floats
) -> GripperModel:
    """The model of a hand whose frame is known."""
    description, pads = mechanism.model, stroke.pads
    axes, origin = palm_to_hand[:3, :3].T, palm_to_hand[:3, 3]
    bodies = hand_bodies(description, mechanism.palm)
    turns, places = map(np.array, zip(*map(mechanism.placement, stroke.positions), strict=True))
    corners = [
        shape @ turns[0, link].T + places[0, link]
        for link, shape in zip(pads.links, pads.corners, strict=True)
    ]
    pad = (np.concatenate(corners) - origin) @ axes.T
    order = [*mechanism.driven, *mechanism.followers]
    return GripperModel(
        links=tuple(hand_link(description, body, bodies, sides) for body in bodies),
        openings=(stroke.middles[:, 1] - stroke.middles[:, 0]) @ sides.axis,
        reach=(stroke.middles - stroke.middles[0]).mean(axis=1) @ axes[2],
        turns=axes @ turns[:, bodies],
        places=(places[:, bodies] - origin) @ axes.T,
        joints=tuple(joint_name(description, joint) for joint in order),
        n_driven=len(mechanism.driven),
        positions=stroke.positions[:, description.jnt_qposadr[order]],
        palm_to_hand=palm_to_hand,
        pad=np.stack([pad.min(axis=0), pad.max(axis=0)]),
    )


def _along(sides: Sides, axis: Floats) -> Sides:
    """The same fingers with a closing axis that was given."""
    axis = axis / np.linalg.norm(axis)
    if axis @ sides.axis < 0:
        return Sides((sides.links[1], sides.links[0]), axis, sides.signs)
    return sides._replace(axis=axis)


def _frame(mechanism: Mechanism, sides: Sides, stroke: Stroke, choices: Choices) -> Floats:
    """Pose of the frame of the hand in that of the palm, (4, 4)."""
    origin = stroke.middles[0].mean(axis=0) if choices.tcp is None else np.array(choices.tcp)
    if choices.approach_axis is None:
        approach = _approach(mechanism, stroke.positions[0], sides.axis, origin)
    else:
        approach = np.array(choices.approach_axis, dtype=np.float64)
    z = approach - (approach @ sides.axis) * sides.axis
    if np.linalg.norm(z) < SHORT:
        raise UserError("its approach is along its closing axis")
    z = z / np.linalg.norm(z)
    pose = np.eye(4)
    pose[:3] = np.stack([sides.axis, np.cross(z, sides.axis), z, origin], axis=1)
    return pose


def _approach(mechanism: Mechanism, positions: Floats, closing: Floats, tip: Floats) -> Floats:
    """Across the closing axis and the axes of hinges, from the palm towards the pads."""
    model = mechanism.model
    shapes = shapes_of(model, mechanism.palm)
    ahead = tip - (np.concatenate(shapes).mean(axis=0) if shapes else np.zeros(3))
    ahead = ahead - (ahead @ closing) * closing
    joints = [*mechanism.driven, *mechanism.followers]
    hinges = [joint for joint in joints if model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_HINGE]
    if hinges:
        across = np.cross(closing, mechanism.axis(hinges[0], positions))
        if np.linalg.norm(across) > 0.5:
            return snapped(across * np.sign(across @ ahead))
    length = float(np.linalg.norm(ahead))
    if length < SHORT:
        raise UserError(
            "it does not show from where it approaches; name the axis: approach_axis: [x, y, z]"
        )
    largest = int(np.abs(ahead).argmax())
    if abs(ahead[largest]) > np.cos(np.radians(UPRIGHT)) * length:
        return np.asarray(np.sign(ahead[largest]) * np.eye(3)[largest])
    return np.asarray(ahead / length)

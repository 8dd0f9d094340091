"""Reading a hand from the URDF or MJCF file that its maker publishes."""

from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray
from pydantic import TypeAdapter
from scipy.optimize import brentq
from scipy.spatial import ConvexHull, QhullError

from egad.errors import UserError
from egad.grippers.description import (
    body_name,
    joint_name,
    moving_joints,
    read_description,
    shapes_of,
    subtree,
)
from egad.grippers.fingers import (
    AT_LEAST,
    Pads,
    Sides,
    find_driven,
    find_pads,
    find_palm,
    find_sides,
    snapped,
)
from egad.grippers.mechanism import Mechanism
from egad.grippers.model import (
    FIRST_FINGER,
    PALM_BODY,
    SECOND_FINGER,
    GripperModel,
    HandLink,
    LinkJoint,
)
from egad.grippers.parameters import Gripper, Place

Floats = NDArray[np.float64]

LEVELS = 65  # openings that are tabulated
UPRIGHT = 20.0  # degrees; an approach this near to an axis of the palm is meant to be that


class Choices(NamedTuple):
    """What is not left to be found in a description.

    Attributes:
        joint: Name of the joint that closes the hand.
        fingers: Name of a link of each finger.
        pads: Names of the links with the pads.
        tcp: Middle of the closed pads in the frame of the palm, metres.
        closing: Axis along which the fingers close, in the frame of the palm.
        approach: Axis along which the hand approaches, in the frame of the palm.
    """

    joint: str | None = None
    fingers: tuple[str, str] | None = None
    pads: tuple[str, str] | None = None
    tcp: Place | None = None
    closing: Place | None = None
    approach: Place | None = None


def read_model(path: Path, choices: Choices = Choices()) -> GripperModel:  # noqa: B008 (a tuple)
    """The hand that a URDF or MJCF file describes.

    Args:
        path: The file.
        choices: What is not left to be found.

    Raises:
        UserError: The file cannot be used, or it is no parallel-jaw hand; with the link or joint.
    """
    changed = path.stat().st_mtime_ns if path.is_file() else 0
    return _read_model(path, choices, changed)


@cache
def _read_model(path: Path, choices: Choices, changed: int) -> GripperModel:
    """The same; a file is read again when it has `changed`."""
    del changed
    description = read_description(path)
    try:
        return _modelled(description, choices)
    except UserError as error:
        raise UserError(f"{path}: {error}") from error


def choices_of(values: Mapping[str, Any]) -> Choices:
    """The choices among the settings of a gripper."""
    names = {"fingers": "finger_links", "pads": "pad_links", "closing": "closing_axis"}
    names |= {"approach": "approach_axis"}
    given = {name: values.get(names.get(name, name)) for name in Choices._fields}
    parsed: Choices = TypeAdapter(Choices).validate_python(given)
    return parsed


def model_of(gripper: Gripper) -> GripperModel:
    """The model of a gripper that has a file.

    Raises:
        UserError: It has none, or the file cannot be used.
    """
    if gripper.file is None:
        raise UserError("this gripper has no file that describes it")
    return read_model(Path(gripper.file), choices_of(gripper.model_dump()))


def _modelled(description: mujoco.MjModel, choices: Choices) -> GripperModel:
    palm, chains = find_palm(description, choices.fingers)
    carried = set().union(*(subtree(description, chain) for chain in chains))
    joints = [
        joint
        for joint in moving_joints(description)
        if int(description.jnt_bodyid[joint]) in carried
    ]
    driven = find_driven(description, joints, choices.joint)
    mechanism = Mechanism(description, driven, [each for each in joints if each not in driven])
    sides = find_sides(mechanism, palm, chains)
    if choices.closing is not None:
        sides = _along(sides, np.array(choices.closing))
    parts = np.linspace(0, 1, LEVELS)
    stroke = _stroke(mechanism, sides, parts)
    pads = find_pads(mechanism, stroke[-1], palm, sides, choices.pads)

    def gap(part: float) -> float:
        """Distance of the pads at a part of the way."""
        (middles,) = _pad_middles(
            mechanism, _stroke(mechanism, sides, np.array([part])), palm, pads
        )
        return float((middles[1] - middles[0]) @ sides.axis)

    middles = _pad_middles(mechanism, stroke, palm, pads)
    start, end = _useful((middles[:, 1] - middles[:, 0]) @ sides.axis)
    closed = end if gap(end) >= 0 else brentq(gap, start, end, xtol=1e-9)
    stroke = _stroke(mechanism, sides, np.linspace(start, closed, LEVELS))
    middles = _pad_middles(mechanism, stroke, palm, pads)
    return _tabulated(mechanism, palm, joints, sides, pads, stroke[::-1], middles[::-1], choices)


def _tabulated(
    mechanism: Mechanism,
    palm: int,
    joints: list[int],
    sides: Sides,
    pads: Pads,
    stroke: list[Floats],
    middles: Floats,
    choices: Choices,
) -> GripperModel:
    """The model, from the positions of all joints and the middles of the pads, closed first."""
    description = mechanism.model
    origin = middles[0].mean(axis=0) if choices.tcp is None else np.array(choices.tcp)
    approach = (
        np.array(choices.approach, dtype=np.float64)
        if choices.approach is not None
        else _approach(mechanism, stroke[0], palm, joints, sides.axis, origin)
    )
    axes = _axes(sides.axis, approach)
    bodies = _bodies(description, palm)
    places = [mechanism.placement(positions, palm) for positions in stroke]
    order = [*mechanism.driven, *mechanism.followers]
    to_hand = np.eye(4)
    to_hand[:3, :3], to_hand[:3, 3] = axes.T, origin
    corners = [
        shape @ places[0].turns[link].T + places[0].places[link]
        for link, shape in zip(pads.links, pads.corners, strict=True)
    ]
    at = (np.concatenate(corners) - origin) @ axes.T
    return GripperModel(
        links=tuple(_link(description, body, bodies, sides) for body in bodies),
        openings=(middles[:, 1] - middles[:, 0]) @ sides.axis,
        reach=(middles - middles[0]).mean(axis=1) @ axes[2],
        turns=np.array([axes @ each.turns[bodies] for each in places]),
        places=np.array([(each.places[bodies] - origin) @ axes.T for each in places]),
        joints=tuple(joint_name(description, joint) for joint in order),
        n_driven=len(mechanism.driven),
        positions=np.array(stroke)[:, description.jnt_qposadr[order]],
        palm_to_hand=to_hand,
        pad=np.stack([at.min(axis=0), at.max(axis=0)]),
    )


def _along(sides: Sides, axis: Floats) -> Sides:
    """The same fingers with a closing axis that was given."""
    axis = axis / np.linalg.norm(axis)
    if axis @ sides.axis < 0:
        return Sides((sides.links[1], sides.links[0]), axis, sides.signs)
    return sides._replace(axis=axis)


def _stroke(mechanism: Mechanism, sides: Sides, parts: Floats) -> list[Floats]:
    """Positions of all joints at parts of the way from one end of the driven ones to the other.

    The joints are followed from the middle outwards, each from where it was.
    """
    ranges = mechanism.ranges()
    start = np.where(sides.signs > 0, ranges[:, 0], ranges[:, 1])
    way = sides.signs * np.ptp(ranges, axis=1)
    found: dict[int, Floats] = {}
    half = int(np.abs(parts - 0.5).argmin())
    for numbers in (range(half, len(parts)), range(half, -1, -1)):
        near = mechanism.middle()
        for number in numbers:
            near = mechanism.follow(start + parts[number] * way, near)
            found[number] = near
    return [found[number] for number in range(len(parts))]


def _useful(gaps: Floats) -> tuple[float, float]:
    """Between which parts of the way the pads come together, up to where they meet.

    Raises:
        UserError: They do not.
    """
    parts = np.linspace(0, 1, len(gaps))
    widest = int(gaps.argmax())
    if gaps[widest] < AT_LEAST:
        raise UserError(f"its pads are at most {1000 * max(gaps[widest], 0):.2g} mm apart")
    last = widest
    while last + 1 < len(gaps) and gaps[last + 1] < gaps[last] and gaps[last] > 0:
        last += 1
    return float(parts[widest]), float(parts[last])


def _pad_middles(mechanism: Mechanism, stroke: Sequence[Floats], palm: int, pads: Pads) -> Floats:
    """The middles of both pads in the frame of the palm, (k, 2, 3)."""
    found = []
    for positions in stroke:
        turns, places = mechanism.placement(positions, palm)
        pair = zip(pads.links, pads.centers, strict=True)
        found.append([turns[link] @ center + places[link] for link, center in pair])
    return np.array(found)


def _approach(
    mechanism: Mechanism,
    positions: Floats,
    palm: int,
    joints: list[int],
    closing: Floats,
    tip: Floats,
) -> Floats:
    """Across the closing axis and the axes of hinges, from the palm towards the pads."""
    model = mechanism.model
    shapes = shapes_of(model, palm)
    ahead = tip - (np.concatenate(shapes).mean(axis=0) if shapes else np.zeros(3))
    ahead = ahead - (ahead @ closing) * closing
    hinges = [joint for joint in joints if model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_HINGE]
    if hinges:
        across = np.cross(closing, mechanism.axis(hinges[0], positions, palm))
        if np.linalg.norm(across) > 0.5:
            return snapped(across * np.sign(across @ ahead))
    length = float(np.linalg.norm(ahead))
    if length < AT_LEAST:
        raise UserError(
            "it does not show from where it approaches; name an axis: approach: [x, y, z]"
        )
    largest = int(np.abs(ahead).argmax())
    if abs(ahead[largest]) > np.cos(np.radians(UPRIGHT)) * length:
        return np.asarray(np.sign(ahead[largest]) * np.eye(3)[largest])
    return np.asarray(ahead / length)


def _axes(closing: Floats, approach: Floats) -> Floats:
    """Unit vectors x, y and z of the hand in rows."""
    z = approach - (approach @ closing) * closing
    if np.linalg.norm(z) < AT_LEAST:
        raise UserError("its approach is along its closing axis")
    z = z / np.linalg.norm(z)
    return np.stack([closing, np.cross(z, closing), z])


def _bodies(model: mujoco.MjModel, palm: int) -> list[int]:
    """The palm, what it carries, and what is fixed behind it."""
    behind, body = [], palm
    while body and not model.body_jntnum[body]:
        body = int(model.body_parentid[body])
        behind.append(body)
    return [palm, *sorted(subtree(model, palm) - {palm}), *(each for each in behind if each)]


def _link(model: mujoco.MjModel, body: int, bodies: list[int], sides: Sides) -> HandLink:
    shapes = []
    for points in shapes_of(model, body):
        try:
            shapes.append(points[ConvexHull(points).vertices])
        except QhullError:  # it is flat, and touches nothing
            continue
    side = (
        FIRST_FINGER
        if body in sides.links[0]
        else SECOND_FINGER
        if body in sides.links[1]
        else PALM_BODY
    )
    carrier = int(model.body_parentid[body])
    moves = side != PALM_BODY and carrier in bodies
    place = np.eye(4)
    mujoco.mju_quat2Mat(turn := np.empty(9), model.body_quat[body])
    place[:3, :3], place[:3, 3] = turn.reshape(3, 3), model.body_pos[body]
    return HandLink(
        body_name(model, body),
        side,
        tuple(shapes),
        float(model.body_mass[body]),
        bodies.index(carrier) if moves else -1,
        place,
        _link_joint(model, body) if moves else None,
    )


def _link_joint(model: mujoco.MjModel, body: int) -> LinkJoint | None:
    """The joint of a link.

    Raises:
        UserError: It has several.
    """
    first, count = int(model.body_jntadr[body]), int(model.body_jntnum[body])
    if count == 0:
        return None
    if count > 1:
        raise UserError(f"the link {body_name(model, body)} has more than one joint")
    slides = int(model.jnt_type[first]) == int(mujoco.mjtJoint.mjJNT_SLIDE)
    return LinkJoint(
        joint_name(model, first),
        "prismatic" if slides else "revolute",
        np.array(model.jnt_axis[first]),
        np.array(model.jnt_pos[first]),
        float(model.qpos0[model.jnt_qposadr[first]]),
    )

"""Read a hand from the URDF or MJCF file that its maker publishes."""

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
from egad.grippers.fingers import (
    Sides,
    find_driven,
    find_moving_jaw,
    find_sides,
    points_of,
    snapped,
)
from egad.grippers.jaw import find_jaw_stroke
from egad.grippers.jaw_solids import JawFrame, JawSolids
from egad.grippers.links import gaps_along, hand_link, jaw_links, jaw_root, lever_of
from egad.grippers.mechanism import (
    Mechanism,
    find_palm,
    hand_bodies,
    joint_name,
    moving_joints,
    subtree,
)
from egad.grippers.model import HandModel
from egad.grippers.pads import UNEVEN, Stroke, find_stroke

log = logging.getLogger(__name__)

SHORT = 5e-4  # metres or of a unit vector: shorter vectors have no direction
# Degrees: an approach this close to an axis of the palm is taken to be that axis, or if the fingers
# are longest along it, since what is mounted on a palm shifts its middle
UPRIGHT, LEANING = 20.0, 40.0


class Choices(NamedTuple):
    """Settings of `Gripper` that replace what would be found in a description."""

    joint: str | None = None
    finger_links: tuple[str, str] | None = None
    pad_links: tuple[str, str] | None = None
    tcp: Place | None = None
    closing_axis: Place | None = None
    approach_axis: Place | None = None


def read_model(path: Path, choices: Choices = Choices()) -> HandModel:  # noqa: B008 (a tuple)
    """The hand that a URDF or MJCF file describes; a `UserError` names the link or joint."""
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
) -> HandModel:
    """As `read_model`; files are read again when the file or one of its `meshes` has `changed`."""
    del meshes
    with name_file_in_messages(path):
        model, beyond = _modelled(_description(path, changed).copy(), path, choices)
    if beyond:
        log.warning(
            "%s: joints that follow others exceed their own limits, which are ignored: %s",
            path,
            ", ".join(beyond),
        )
    return model


def choices_of(values: Mapping[str, Any]) -> Choices:
    """The choices among the settings of a gripper."""
    given = {name: values.get(name) for name in Choices._fields}
    parsed: Choices = TypeAdapter(Choices).validate_python(given)
    return parsed


def _modelled(spec: mujoco.MjSpec, path: Path, choices: Choices) -> tuple[HandModel, list[str]]:
    """The model of a hand, and the joints that go beyond their own limits."""
    bare = compile_skeleton(spec)
    palm, chains = find_palm(bare, choices.finger_links)
    carried = set().union(*(subtree(bare, chain) for chain in chains))
    joints = [joint for joint in moving_joints(bare) if int(bare.jnt_bodyid[joint]) in carried]
    driven = find_driven(bare, joints, choices.joint)
    followers = [each for each in joints if each not in driven]
    description = compile_with_shapes(spec, path, hand_bodies(bare, palm))
    mechanism = Mechanism(description, palm, driven, followers)
    if (jaw := find_moving_jaw(mechanism, chains)) is not None:
        return _with_one_jaw(mechanism, jaw, choices), []
    sides = find_sides(mechanism, chains)
    if choices.closing_axis is not None:
        axis, (first, second) = _unit(choices.closing_axis), sides.links
        swapped = axis @ sides.axis < 0
        sides = sides._replace(links=(second, first) if swapped else (first, second), axis=axis)
    stroke = find_stroke(mechanism, sides, choices.pad_links)
    model = _tabulated(mechanism, sides, stroke, _frame(mechanism, sides, stroke, choices))
    return model, mechanism.joints_beyond_limits(stroke.positions)


def _tabulated(
    mechanism: Mechanism, sides: Sides, stroke: Stroke, palm_to_hand: Floats
) -> HandModel:
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
    grooved = pads.links if pads.recess[1] > UNEVEN else ()
    return HandModel(
        links=tuple(
            hand_link(description, body, bodies, sides, grooved=body in grooved) for body in bodies
        ),
        openings=(stroke.middles[:, 1] - stroke.middles[:, 0]) @ sides.axis,
        reach=(stroke.middles - stroke.middles[0]).mean(axis=1) @ axes[2],
        aside=np.zeros(len(stroke.middles)),
        angles=np.zeros(len(stroke.middles)),
        turns=axes @ turns[:, bodies],
        places=(places[:, bodies] - origin) @ axes.T,
        joints=tuple(joint_name(description, joint) for joint in order),
        n_driven=len(mechanism.driven),
        positions=stroke.positions[:, description.jnt_qposadr[order]],
        palm_to_hand=palm_to_hand,
        pad=np.stack([pad.min(axis=0), pad.max(axis=0)]),
        recess=pads.recess,
    )


def _with_one_jaw(mechanism: Mechanism, body: int, choices: Choices) -> HandModel:
    """The model of a hand of which one jaw is part of the palm."""
    description, palm = mechanism.model, mechanism.palm
    moving = subtree(description, body)
    static = [each for each in hand_bodies(description, palm) if each not in moving]
    jaws = JawSolids(mechanism, body, static)
    closing, points = jaws.facing.axis, jaws.facing.points
    if choices.closing_axis is not None:
        closing = _unit(choices.closing_axis)
    behind, joint = jaws.middle, mechanism.driven[0]
    if description.jnt_type[joint] == mujoco.mjtJoint.mjJNT_HINGE:
        behind = mechanism.anchor(joint, mechanism.middle())
        turn = float(np.ptp(mechanism.ranges()[0]))
        if turn > 2 * np.pi:
            raise UserError(
                f"the joint {joint_name(description, joint)} turns by {turn:.3g} rad, more than "
                "once around; limits of turning joints are in radians"
            )
    ahead = points.mean(axis=0) - behind
    z = _towards(mechanism, mechanism.middle(), closing, ahead, choices)
    frame = JawFrame(closing, np.cross(z, closing), z)
    stroke = find_jaw_stroke(
        jaws, frame, None if choices.tcp is None else np.array(choices.tcp, dtype=np.float64)
    )
    half = stroke.openings / 2
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = frame.matrix, stroke.pads.middle + half[0] * closing
    root = jaw_root(jaws, frame, stroke)
    links = jaw_links(jaws, frame, root, static)
    depths, gaps = gaps_along(jaws, frame, stroke, root)
    poses = [mechanism.placement(each) for each in stroke.positions]
    turns = np.array([[np.eye(3), np.eye(3), each.turns[body]] for each in poses])
    places = np.array([[np.zeros(3), np.zeros(3), each.places[body]] for each in poses])
    corner = np.array([half[0], *(stroke.pads.extent / 2)])
    return HandModel(
        links=links,
        openings=stroke.openings,
        reach=np.zeros_like(half),
        aside=half - half[0],
        angles=stroke.angles,
        turns=frame.matrix.T @ turns,
        places=(places - pose[:3, 3]) @ frame.matrix,
        joints=(joint_name(description, mechanism.driven[0]),),
        n_driven=1,
        positions=stroke.positions[:, description.jnt_qposadr[mechanism.driven]],
        palm_to_hand=pose,
        pad=np.stack([-corner, corner]),
        recess=stroke.pads.recess,
        lever=lever_of(jaws, stroke, frame),
        depths=depths,
        gaps=gaps,
    )


def _unit(axis: Place) -> Floats:
    """A given closing axis as a unit vector."""
    vector = np.array(axis, dtype=np.float64)
    length = float(np.linalg.norm(vector))
    if not length > SHORT:
        raise UserError(f"closing_axis {list(axis)} has no direction")
    return np.asarray(vector / length)


def _frame(mechanism: Mechanism, sides: Sides, stroke: Stroke, choices: Choices) -> Floats:
    """Pose of the frame of the hand in that of the palm, (4, 4)."""
    origin = stroke.middles[0].mean(axis=0) if choices.tcp is None else np.array(choices.tcp)
    shapes = shapes_of(mechanism.model, mechanism.palm)
    ahead = origin - (np.concatenate(shapes).mean(axis=0) if shapes else np.zeros(3))
    z = _towards(mechanism, stroke.positions[0], sides.axis, ahead, choices)
    pose = np.eye(4)
    pose[:3] = np.stack([sides.axis, np.cross(z, sides.axis), z, origin], axis=1)
    return pose


def _towards(
    mechanism: Mechanism, positions: Floats, closing: Floats, ahead: Floats, choices: Choices
) -> Floats:
    """The approach as a unit vector at right angles to the closing axis; see `_approach`."""
    if choices.approach_axis is None:
        approach = _approach(mechanism, positions, closing, ahead)
    else:
        approach = np.array(choices.approach_axis, dtype=np.float64)
    z = approach - (approach @ closing) * closing
    if np.linalg.norm(z) < SHORT:
        raise UserError("its approach is along its closing axis")
    return np.asarray(z / np.linalg.norm(z))


def _approach(mechanism: Mechanism, positions: Floats, closing: Floats, ahead: Floats) -> Floats:
    """The direction across the closing axis and hinges, from the palm towards the pads: `ahead`."""
    model = mechanism.model
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
            "its approach direction cannot be determined; give it: approach_axis: [x, y, z]"
        )
    axis = np.eye(3)[int(np.abs(ahead).argmax())]
    axis *= np.sign(axis @ ahead)
    moving = set().union(*(subtree(model, int(model.jnt_bodyid[joint])) for joint in joints))
    fingers = points_of(mechanism, positions, moving)
    beside, along = np.ptp(fingers @ np.stack([np.cross(closing, axis), axis], axis=1), axis=0)
    if axis @ ahead > np.cos(np.radians(LEANING if along > beside else UPRIGHT)) * length:
        return np.asarray(axis)
    return np.asarray(ahead / length)

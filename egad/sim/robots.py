"""The robots of trials: a hand on a vertical axis, by itself, or at the flange of a Panda arm."""

from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from egad._util.arrays import Floats
from egad.grippers import (
    PALM_BODY,
    SECOND_FINGER,
    Gripper,
    HandLink,
    HandModel,
    SuctionCup,
    finger_span,
    model_of,
)
from egad.sim.robot import (
    LEFT,
    PALM,
    RIGHT,
    TIP,
    Box,
    Follower,
    HullShape,
    JawJoint,
    Joint,
    Link,
    Robot,
    Vector,
)

PALM_MASS = 0.6
STEM_SIDES = 16
FINGER_MASS = 0.1
STROKE = 2.0  # metres, of the vertical axis, both ways
TURN = 10.0  # radians, of the axis, both ways
AXIS_STRENGTH = (500.0, 20.0)  # N and N m: much stronger than the fingers
FREE_STRENGTH = 200.0  # newtons, along each axis of a hand without an arm
QUARTER = np.pi / 2
# For each joint of a Panda: its origin in the previous link (metres), its rotation about x, its
# limits, as in Franka's documentation, its torque (N m), and the mass of its link (Gaz et al. 2019,
# table IV).
PANDA_JOINTS: tuple[tuple[Vector, float, tuple[float, float], float, float], ...] = (
    ((0.0, 0.0, 0.333), 0.0, (-2.8973, 2.8973), 87.0, 4.971),
    ((0.0, 0.0, 0.0), -QUARTER, (-1.7628, 1.7628), 87.0, 0.647),
    ((0.0, -0.316, 0.0), QUARTER, (-2.8973, 2.8973), 87.0, 3.229),
    ((0.0825, 0.0, 0.0), QUARTER, (-3.0718, -0.0698), 87.0, 3.588),
    ((-0.0825, 0.384, 0.0), -QUARTER, (-2.8973, 2.8973), 12.0, 1.226),
    ((0.0, 0.0, 0.0), QUARTER, (-0.0175, 3.7525), 12.0, 1.667),
    ((0.088, 0.0, 0.0), QUARTER, (-2.8973, 2.8973), 12.0, 0.736),
)
PANDA_FLANGE = (0.0, 0.0, 0.107)  # in the last link
PANDA_THICKNESS = 0.1  # metres, of the boxes that represent its links
# Kilograms. Carriages have the inertia of a geared motor. If links were much lighter, PyBullet
# would not solve their joints.
CARRIAGE_MASS, MIN_MASS = 0.5, 0.05
LOOSE = 0.1  # metres or radians that joints of a linkage may exceed their range
OWN = "hand-"  # prefix of the names of the links of a model


def on_axis(gripper: Gripper) -> Robot:
    """The hand on a vertical axis that turns: at 0 the fingertips are on the ground."""
    hand = _hand(gripper)
    top = (0.0, 0.0, hand.length)
    return _with_hand(
        hand,
        gripper,
        (Link("stand"), Link("height")),
        (
            # Turned upside down, so that the hand points down
            Joint(
                "height", "stand", "prismatic", top, (np.pi, 0, 0), (0, 0, -1), (-STROKE, STROKE)
            ),
            Joint(PALM, "height", "revolute", axis=(0, 0, -1), limits=(-TURN, TURN)),
        ),
        dict(zip(("height", PALM), AXIS_STRENGTH, strict=True)),
    )


def free_hand(gripper: Gripper) -> Robot:
    """The hand by itself, moved along its own axes: at 0 the fingertips are at the origin."""
    hand = _hand(gripper)
    root = (0.0, 0.0, -hand.length)
    names = ("along_x", "along_y", PALM)
    axes: tuple[Vector, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    moving = tuple(
        Joint(name, parent, "prismatic", origin, axis=axis, limits=(-STROKE, STROKE))
        for name, parent, origin, axis in zip(
            names, ("stand", *names), (root, (0.0,) * 3, (0.0,) * 3), axes, strict=False
        )
    )
    return _with_hand(
        hand,
        gripper,
        (Link("stand"), Link("along_x"), Link("along_y")),
        moving,
        dict.fromkeys(names, FREE_STRENGTH),
    )


def on_panda(gripper: Gripper) -> Robot:
    """The hand at the flange of a Franka Panda arm, in place of Franka's own."""
    links, joints, strength = [Link("panda0", 0.0)], [], {}
    ends = [joint[0] for joint in PANDA_JOINTS[1:]] + [PANDA_FLANGE]
    for number, ((origin, turn, limits, torque, mass), end) in enumerate(
        zip(PANDA_JOINTS, ends, strict=True), 1
    ):
        name = f"panda{number}"
        links.append(Link(name, mass, (_around(end),)))
        joints.append(
            Joint(name, f"panda{number - 1}", "revolute", origin, (turn, 0, 0), limits=limits)
        )
        strength[name] = torque
    # The fingers close along x of the palm, and along y of the flange.
    flange = Joint(PALM, f"panda{len(PANDA_JOINTS)}", origin=PANDA_FLANGE, turn=(0, 0, QUARTER))
    return _with_hand(_hand(gripper), gripper, tuple(links), (*joints, flange), strength)


class _Hand(NamedTuple):
    """A hand: x closes, z is the approach, and the palm begins at the origin of its frame.

    The joint of the palm is left to the arm. `length` is the distance from the back of the palm to
    the fingertips; for the other attributes see `Robot`.
    """

    links: list[Link]
    joints: list[Joint]
    length: float
    sides: dict[str, str]
    followers: tuple[Follower, ...] = ()
    path: tuple[Floats, Floats] | None = None
    jaw: JawJoint | None = None


def _with_hand(
    hand: _Hand,
    gripper: Gripper,
    links: tuple[Link, ...],
    joints: tuple[Joint, ...],
    strength: dict[str, float],
) -> Robot:
    """A robot from the links and joints of an arm, and a hand."""
    return Robot(
        gripper,
        (*links, *hand.links),
        (*joints, *hand.joints),
        strength,
        hand.sides,
        hand.followers,
        hand.path,
        hand.jaw,
    )


def _hand(gripper: Gripper) -> _Hand:
    if gripper.cup is not None:
        return _cup_hand(gripper.cup)
    return _box_hand(gripper) if gripper.file is None else _model_hand(gripper)


def _cup_hand(cup: SuctionCup) -> _Hand:
    """A stem that collides, and below it the cup, which is soft."""
    whole = cup.stem_length + cup.height
    stem = HullShape(_frustum(cup.stem_radius, cup.stem_radius, 0.0, cup.stem_length))
    skirt = HullShape(_frustum(cup.stem_radius / 2, cup.radius, cup.stem_length, whole))
    links = [Link(PALM, PALM_MASS, (stem,), (skirt,)), Link(TIP)]
    return _Hand(links, [Joint(TIP, PALM, origin=(0, 0, whole))], whole, {})


def _frustum(first: float, second: float, low: float, high: float) -> Floats:
    """The corners of a frustum of a pyramid around z, (2 * STEM_SIDES, 3), metres."""
    angles = 2 * np.pi * np.arange(STEM_SIDES) / STEM_SIDES
    around = np.stack([np.cos(angles), np.sin(angles), np.zeros(STEM_SIDES)], axis=1)
    return np.vstack([first * around + [0, 0, low], second * around + [0, 0, high]])


def _box_hand(gripper: Gripper) -> _Hand:
    """Palm and fingers as boxes."""
    length, palm = gripper.finger_length, gripper.palm
    finger = (gripper.finger_thickness, gripper.finger_width, length)
    links = [Link(PALM, PALM_MASS, (Box(palm, (0.0, 0.0, palm[2] / 2)),))]
    joints = []
    for name, side in ((LEFT, 1.0), (RIGHT, -1.0)):
        box = Box(finger, (side * finger[0] / 2, 0.0, length / 2))
        links.append(Link(name, FINGER_MASS, (box,)))
        limits = (0.0, gripper.opening / 2)
        place = (0.0, 0.0, palm[2])
        joints.append(Joint(name, PALM, "prismatic", place, axis=(side, 0, 0), limits=limits))
    whole = palm[2] + length
    sides = {name: name for name in (LEFT, RIGHT)}
    return _Hand(
        [*links, Link(TIP)], [*joints, Joint(TIP, PALM, origin=(0, 0, whole))], whole, sides
    )


def _model_hand(gripper: Gripper) -> _Hand:
    """The links and joints of a maker's model, with a carriage for each finger if both move."""
    model = model_of(gripper)
    closed = list(zip(model.links, model.points(float(model.openings[0])), strict=True))
    fixed = [points for link, shapes in closed for points in shapes if link.body == PALM_BODY]
    tip = finger_span(gripper)[1]
    back = min((float(points[:, 2].min()) for points in fixed), default=tip - gripper.finger_length)
    raised = np.array([0.0, 0.0, -back])
    mass = sum(link.mass for link in model.links if link.body == PALM_BODY)
    palm = Link(PALM, max(mass, MIN_MASS), tuple(HullShape(points + raised) for points in fixed))
    links, joints, sides = [palm], [], {}
    for name, way in ((LEFT, 1.0), (RIGHT, -1.0)) if model.lever is None else ():
        limits = (float(model.openings[0]) / 2, gripper.opening / 2)
        links.append(Link(name, CARRIAGE_MASS))
        joints.append(Joint(name, PALM, "prismatic", axis=(way, 0, 0), limits=limits))
    followers, jaw = list[Follower](), None
    for link in model.links:
        if link.body == PALM_BODY:
            continue
        side = LEFT if link.body == SECOND_FINGER else RIGHT
        shapes = tuple(HullShape(points - _anchor(link)) for points in link.shapes)
        links.append(Link(OWN + link.name, max(link.mass, MIN_MASS), shapes))
        joint = _model_joint(model, link, raised)
        joints.append(joint)
        sides[OWN + link.name] = side
        if link.joint is None:
            continue
        column = model.positions[:, model.joints.index(link.joint.name)] - link.joint.zero
        if model.lever is None:
            followers.append(Follower(OWN + link.name, side, model.openings / 2, column))
        else:
            jaw = JawJoint(OWN + link.name, model.openings, column, model.lever)
    length = tip - back
    return _Hand(
        [*links, Link(TIP)],
        [*joints, Joint(TIP, PALM, origin=(0, 0, length))],
        length,
        sides,
        tuple(followers),
        (model.openings, model.reach),
        jaw,
    )


def _model_joint(model: HandModel, link: HandLink, raised: Floats) -> Joint:
    """The joint of a link, whose frame is moved so that the axis goes through its origin."""
    carrier = model.links[link.carrier]
    before, after = np.eye(4), np.eye(4)
    after[:3, 3] = _anchor(link)
    if carrier.body == PALM_BODY:
        parent = PALM
        before[:3, :3], before[:3, 3] = model.turns[0, link.carrier], model.places[0, link.carrier]
        before[:3, 3] += raised
    else:
        parent = OWN + carrier.name
        before[:3, 3] = -_anchor(carrier)
    pose = before @ link.place @ after
    turn = Rotation.from_matrix(pose[:3, :3]).as_rotvec()
    origin = _vector(pose[:3, 3])
    if link.joint is None:
        return Joint(OWN + link.name, parent, origin=origin, turn=_vector(turn))
    column = model.positions[:, model.joints.index(link.joint.name)] - link.joint.zero
    loose = LOOSE if model.lever is None else 0.0
    return Joint(
        OWN + link.name,
        parent,
        link.joint.kind,
        origin,
        _vector(turn),
        _vector(link.joint.axis),
        (float(column.min()) - loose, float(column.max()) + loose),
    )


def _anchor(link: HandLink) -> Floats:
    return np.zeros(3) if link.joint is None else link.joint.anchor


def _vector(values: Floats) -> Vector:
    x, y, z = map(float, values)
    return x, y, z


def _around(end: Vector) -> Box:
    """A box around the line from the origin of a link of the Panda to the end of the link."""
    x, y, z = (abs(value) + PANDA_THICKNESS for value in end)
    return Box((x, y, z), (end[0] / 2, end[1] / 2, end[2] / 2))

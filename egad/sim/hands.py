"""The links and joints of hands: boxes, a maker's model, or a suction cup on a stem.

What a file describes goes to the engines by way of `HandModel`, because they move fingers by the
opening, which it tabulates. Neither engine could take the file itself: hands that close by tendons,
springs or loops of links become joints that follow the opening, and all parts become convex.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from egad._util.arrays import Floats
from egad.grippers import (
    PALM_BODY,
    SECOND_FINGER,
    BoxBody,
    CupBody,
    Gripper,
    HandBody,
    HandLink,
    HandModel,
    JawBody,
    ModelBody,
    body_of,
    finger_span,
)
from egad.grippers.model import LinkJoint
from egad.sim.drives import LEFT, RIGHT, CupDrive, Drive, FingerDrive, Follower, JawDrive
from egad.sim.robot import PALM, TIP, Box, HullShape, Joint, Link, vector

PALM_MASS = 0.6
STEM_SIDES = 16
FINGER_MASS = 0.1
# Kilograms. Carriages have the inertia of a geared motor. If links were much lighter, PyBullet
# would not solve their joints.
CARRIAGE_MASS, MIN_MASS = 0.5, 0.05
LOOSE = 0.1  # metres or radians that joints of a linkage may exceed their range
OWN = "hand-"  # prefix of the names of the links of a model


class HandParts(NamedTuple):
    """A hand: x closes, z approaches, the palm begins at 0; `length` from its back, metres."""

    links: list[Link]
    joints: list[Joint]
    length: float
    sides: dict[str, str]
    drive: Drive
    followers: tuple[Follower, ...] = ()
    path: tuple[Floats, Floats] | None = None


def _cup_hand(body: CupBody) -> HandParts:
    """A stem that collides, and below it the cup, which is soft."""
    cup = body.cup
    whole = cup.stem_length + cup.height
    stem = HullShape(_frustum(cup.stem_radius, cup.stem_radius, 0.0, cup.stem_length))
    skirt = HullShape(_frustum(cup.stem_radius / 2, cup.radius, cup.stem_length, whole))
    links = [Link(PALM, PALM_MASS, (stem,), (skirt,)), Link(TIP)]
    return HandParts(links, [Joint(TIP, PALM, origin=(0, 0, whole))], whole, {}, CupDrive(cup))


def _frustum(first: float, second: float, low: float, high: float) -> Floats:
    """The corners of a frustum of a pyramid around z, (2 * STEM_SIDES, 3), metres."""
    angles = 2 * np.pi * np.arange(STEM_SIDES) / STEM_SIDES
    around = np.stack([np.cos(angles), np.sin(angles), np.zeros(STEM_SIDES)], axis=1)
    return np.vstack([first * around + [0, 0, low], second * around + [0, 0, high]])


def _box_hand(body: BoxBody) -> HandParts:
    """Palm and fingers as boxes."""
    gripper = body.gripper
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
    joints.append(Joint(TIP, PALM, origin=(0, 0, whole)))
    return HandParts([*links, Link(TIP)], joints, whole, sides, FingerDrive(gripper.force))


def _finger_hand(body: ModelBody) -> HandParts:
    """Two fingers of a maker's model, whose joints follow a carriage for each."""
    model, gripper = body.model, body.gripper
    limits = (float(model.openings[0]) / 2, gripper.opening / 2)
    carriages = [
        Joint(name, PALM, "prismatic", axis=(way, 0, 0), limits=limits)
        for name, way in ((LEFT, 1.0), (RIGHT, -1.0))
    ]
    followers = tuple(
        Follower(OWN + link.name, _side(link), model.openings / 2, _positions(model, link.joint))
        for link in model.links
        if link.joint is not None
    )
    parts = _model_hand(body, FingerDrive(gripper.force), carriages, LOOSE)
    return parts._replace(followers=followers)


def _one_jaw_hand(body: JawBody) -> HandParts:
    """The fixed jaw of a maker's model, and the moving one."""
    model = body.model
    ((name, joint),) = ((link.name, link.joint) for link in model.links if link.joint is not None)
    positions, force = _positions(model, joint), body.gripper.force
    drive = JawDrive(OWN + name, model.openings, positions, body.lever, force)
    return _model_hand(body, drive, [], 0.0)


def _model_hand(body: ModelBody, drive: Drive, carriages: list[Joint], loose: float) -> HandParts:
    """The links and joints of a maker's model, which exceed their range by `loose`."""
    model, gripper = body.model, body.gripper
    closed = list(zip(model.links, model.points(float(model.openings[0])), strict=True))
    fixed = [points for link, shapes in closed for points in shapes if link.body == PALM_BODY]
    tip = finger_span(gripper)[1]
    back = min((float(points[:, 2].min()) for points in fixed), default=tip - gripper.finger_length)
    raised = np.array([0.0, 0.0, -back])
    mass = sum(link.mass for link in model.links if link.body == PALM_BODY)
    palm = Link(PALM, max(mass, MIN_MASS), tuple(HullShape(points + raised) for points in fixed))
    moving = [link for link in model.links if link.body != PALM_BODY]
    links = [palm, *(Link(joint.child, CARRIAGE_MASS) for joint in carriages)]
    for link in moving:
        shapes = tuple(HullShape(points - _anchor(link)) for points in link.shapes)
        links.append(Link(OWN + link.name, max(link.mass, MIN_MASS), shapes))
    joints = [*carriages, *(_model_joint(model, link, raised, loose) for link in moving)]
    length = tip - back
    return HandParts(
        [*links, Link(TIP)],
        [*joints, Joint(TIP, PALM, origin=(0, 0, length))],
        length,
        {OWN + link.name: _side(link) for link in moving},
        drive,
        path=(model.openings, model.reach),
    )


def _side(link: HandLink) -> str:
    return LEFT if link.body == SECOND_FINGER else RIGHT


def _positions(model: HandModel, joint: LinkJoint) -> Floats:
    """Positions of a joint at the openings of a model, from where its link is at its place."""
    return np.asarray(model.positions[:, model.joints.index(joint.name)] - joint.zero)


def _model_joint(model: HandModel, link: HandLink, raised: Floats, loose: float) -> Joint:
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
    origin = vector(pose[:3, 3])
    if link.joint is None:
        return Joint(OWN + link.name, parent, origin=origin, turn=vector(turn))
    column = _positions(model, link.joint)
    return Joint(
        OWN + link.name,
        parent,
        link.joint.kind,
        origin,
        vector(turn),
        vector(link.joint.axis),
        (float(column.min()) - loose, float(column.max()) + loose),
    )


def _anchor(link: HandLink) -> Floats:
    return np.zeros(3) if link.joint is None else link.joint.anchor


HANDS: dict[type[HandBody], Callable[..., HandParts]] = {
    BoxBody: _box_hand,
    ModelBody: _finger_hand,
    JawBody: _one_jaw_hand,
    CupBody: _cup_hand,
}


def hand_parts(gripper: Gripper) -> HandParts:
    """The links and joints of a gripper; `UserError` if its file cannot be used."""
    body = body_of(gripper)
    return HANDS[type(body)](body)

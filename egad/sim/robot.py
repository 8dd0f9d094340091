"""The parallel-jaw hand of the gripper table as links and joints: on an arm, or free."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from egad.grasps import Gripper

Floats = NDArray[np.float64]
Vector = tuple[float, float, float]
Motion = Callable[[float], Floats]

PALM, LEFT, RIGHT, TIP = "palm", "left", "right", "tip"
PALM_MASS = 0.6
FINGER_MASS = 0.1
STROKE = 2.0  # metres, of the vertical axis, both ways
TURN = 10.0  # radians, of the axis, both ways
AXIS_STRENGTH = (500.0, 20.0)  # N and N m: much stronger than the fingers
FREE_STRENGTH = 200.0  # newtons, along each axis of a hand without an arm
QUARTER = np.pi / 2
# Of a Panda: where each joint lies in the link before (metres), its turn about x, its limits, as in
# Franka's documentation, its torque (N m), and the mass of its link (Gaz et al. 2019, table IV).
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
PANDA_THICKNESS = 0.1  # metres, of the boxes that stand for its links


@dataclass(frozen=True)
class Box:
    """A box whose sides are parallel to the axes of its link.

    Attributes:
        size: Of its sides, metres.
        center: In the frame of the link, metres.
    """

    size: Vector
    center: Vector


@dataclass(frozen=True)
class Link:
    """A rigid body of a robot, of uniform density within its box; without mass if it has none."""

    name: str
    mass: float = 0.0
    box: Box | None = None


@dataclass(frozen=True)
class Joint:
    """How a link is carried by another one.

    Attributes:
        child: Name of the link; that of the joint, too.
        parent: Name of what carries it.
        kind: How it moves.
        origin: Of the child's frame in that of the parent at 0, metres.
        turn: Of the child's frame, a rotation vector, radians.
        axis: It moves along or about, in the frame of the child.
        limits: Of the motion, metres or radians.
    """

    child: str
    parent: str
    kind: Literal["prismatic", "revolute", "fixed"] = "fixed"
    origin: Vector = (0.0, 0.0, 0.0)
    turn: Vector = (0.0, 0.0, 0.0)
    axis: Vector = (0.0, 0.0, 1.0)
    limits: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True)
class Robot:
    """An arm, and at its end a palm with two fingers that move as mirror images.

    Attributes:
        gripper: Force and pads of the fingers.
        links: The root first.
        joints: One for each link but the root, in the same order.
        strength: Force or torque of each joint of the arm, by its name, N or N m.
    """

    gripper: Gripper
    links: tuple[Link, ...]
    joints: tuple[Joint, ...]
    strength: dict[str, float] = field(hash=False)

    @property
    def pad_friction(self) -> tuple[float, float]:
        """Friction of the pads: sliding, and torsional (m, torque over normal force).

        A soft pad resists twisting even where a round object touches it in one point: as a pressed
        disc.
        """
        friction, radius = self.gripper.pad
        return friction, 2 / 3 * friction * radius

    @property
    def arm(self) -> tuple[str, ...]:
        """Names of the joints that move the palm, in the order of their positions."""
        return tuple(self.strength)

    def tip_poses(self, positions: Sequence[float]) -> list[Floats]:
        """Where the joints of the arm and the tip are: (4, 4) transforms to the root's frame.

        Args:
            positions: Of the joints of the arm, metres or radians.

        Returns:
            The frames of the arm's joints in their order, then that of the tip.
        """
        values, poses = iter(positions), []
        pose = np.eye(4)
        for moves, motion in self._chain:
            pose = pose @ motion(next(values) if moves else 0.0)
            if moves:
                poses.append(pose)
        return [*poses, pose]

    @cached_property
    def _chain(self) -> list[tuple[bool, Motion]]:
        """The joints from the root to the tip: whether the arm moves them, and how."""
        carried = [joint for joint in self.joints if joint.child not in (LEFT, RIGHT)]
        return [(joint.child in self.strength, _motion(joint)) for joint in carried]


def on_axis(gripper: Gripper) -> Robot:
    """The hand on a vertical axis that turns: at 0 the fingertips stand on the ground."""
    top = (0.0, 0.0, gripper.palm[2] + gripper.finger_length)
    links, joints = _hand(gripper)
    return Robot(
        gripper,
        (Link("stand"), Link("height"), *links),
        (
            # Turned over, so that the hand points down
            Joint(
                "height", "stand", "prismatic", top, (np.pi, 0, 0), (0, 0, -1), (-STROKE, STROKE)
            ),
            Joint(PALM, "height", "revolute", axis=(0, 0, -1), limits=(-TURN, TURN)),
            *joints,
        ),
        dict(zip(("height", PALM), AXIS_STRENGTH, strict=True)),
    )


def free_hand(gripper: Gripper) -> Robot:
    """The hand by itself, moved along its own axes: at 0 the fingertips are at the origin."""
    root = (0.0, 0.0, -gripper.palm[2] - gripper.finger_length)
    links, joints = _hand(gripper)
    names = ("along_x", "along_y", PALM)
    axes: tuple[Vector, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    moving = [
        Joint(name, parent, "prismatic", origin, axis=axis, limits=(-STROKE, STROKE))
        for name, parent, origin, axis in zip(
            names, ("stand", *names), (root, (0.0,) * 3, (0.0,) * 3), axes, strict=False
        )
    ]
    return Robot(
        gripper,
        (Link("stand"), Link("along_x"), Link("along_y"), *links),
        (*moving, *joints),
        dict.fromkeys(names, FREE_STRENGTH),
    )


def on_panda(gripper: Gripper) -> Robot:
    """The hand at the flange of a Franka Panda arm, in the place of Franka's own."""
    links, joints, strength = [Link("panda0", 0.0)], [], {}
    ends = [joint[0] for joint in PANDA_JOINTS[1:]] + [PANDA_FLANGE]
    for number, ((origin, turn, limits, torque, mass), end) in enumerate(
        zip(PANDA_JOINTS, ends, strict=True), 1
    ):
        name = f"panda{number}"
        links.append(Link(name, mass, _around(end)))
        joints.append(
            Joint(name, f"panda{number - 1}", "revolute", origin, (turn, 0, 0), limits=limits)
        )
        strength[name] = torque
    own_links, own_joints = _hand(gripper)
    # The fingers close along x of the palm, and along y of the flange.
    flange = Joint(PALM, f"panda{len(PANDA_JOINTS)}", origin=PANDA_FLANGE, turn=(0, 0, QUARTER))
    return Robot(gripper, (*links, *own_links), (*joints, flange, *own_joints), strength)


def to_urdf(robot: Robot) -> str:
    """The robot as URDF."""
    root = Element("robot", name="robot")
    for link in robot.links:
        _write_link(root, link)
    for joint in robot.joints:
        element = SubElement(root, "joint", name=joint.child, type=joint.kind)
        _write_origin(element, joint.origin, joint.turn)
        SubElement(element, "parent", link=joint.parent)
        SubElement(element, "child", link=joint.child)
        if joint.kind != "fixed":
            SubElement(element, "axis", xyz=_text(joint.axis))
            low, high = map(repr, joint.limits)
            SubElement(element, "limit", lower=low, upper=high, effort="1000", velocity="10")
    return ElementTree.tostring(root, encoding="unicode")


def _hand(gripper: Gripper) -> tuple[list[Link], list[Joint]]:
    """Palm and fingers as boxes: x closes, z is the approach, the palm begins at its origin.

    The joint of the palm is left to the arm.
    """
    length, palm = gripper.finger_length, gripper.palm
    finger = (gripper.finger_thickness, gripper.finger_width, length)
    links = [Link(PALM, PALM_MASS, Box(palm, (0.0, 0.0, palm[2] / 2)))]
    joints = []
    for name, side in ((LEFT, 1.0), (RIGHT, -1.0)):
        box = Box(finger, (side * finger[0] / 2, 0.0, length / 2))
        links.append(Link(name, FINGER_MASS, box))
        limits = (0.0, gripper.opening / 2)
        place = (0.0, 0.0, palm[2])
        joints.append(Joint(name, PALM, "prismatic", place, axis=(side, 0, 0), limits=limits))
    return [*links, Link(TIP)], [*joints, Joint(TIP, PALM, origin=(0, 0, palm[2] + length))]


def _around(end: Vector) -> Box:
    """A box around the line from the origin of a link of the Panda to the end of the link."""
    x, y, z = (abs(value) + PANDA_THICKNESS for value in end)
    return Box((x, y, z), (end[0] / 2, end[1] / 2, end[2] / 2))


def _motion(joint: Joint) -> Motion:
    """From a joint's position to the (4, 4) transform from the child's frame to the parent's."""
    fixed = np.eye(4)
    fixed[:3, :3] = Rotation.from_rotvec(joint.turn).as_matrix()
    fixed[:3, 3] = joint.origin
    x, y, z = joint.axis
    shift, cross = np.zeros((2, 4, 4))
    shift[:3, 3] = fixed[:3, :3] @ joint.axis
    cross[:3, :3] = [[0, -z, y], [z, 0, -x], [-y, x, 0]]
    first, second = fixed @ cross, fixed @ cross @ cross
    if joint.kind == "prismatic":
        return lambda value: fixed + value * shift
    # Rodrigues' formula
    return lambda value: fixed + math.sin(value) * first + (1 - math.cos(value)) * second


def _write_link(root: Element, link: Link) -> None:
    element = SubElement(root, "link", name=link.name)
    box = link.box or Box((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    inertial = SubElement(element, "inertial")
    _write_origin(inertial, box.center)
    SubElement(inertial, "mass", value=repr(link.mass))
    squares = [side**2 for side in box.size]
    moments = [repr(link.mass / 12 * (sum(squares) - square)) for square in squares]
    values = dict(zip(("ixx", "iyy", "izz"), moments, strict=True))
    SubElement(inertial, "inertia", {**values, "ixy": "0", "ixz": "0", "iyz": "0"})
    if link.box is not None:
        part = SubElement(element, "collision")
        _write_origin(part, box.center)
        SubElement(SubElement(part, "geometry"), "box", size=_text(box.size))


def _write_origin(element: Element, origin: Vector, turn: Vector = (0.0, 0.0, 0.0)) -> None:
    angles = Rotation.from_rotvec(turn).as_euler("xyz")
    SubElement(element, "origin", xyz=_text(origin), rpy=_text(tuple(angles)))


def _text(values: Sequence[float]) -> str:
    return " ".join(repr(float(value)) for value in values)

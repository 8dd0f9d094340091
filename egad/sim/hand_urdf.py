"""The parallel-jaw hand of the gripper table as URDF, on a vertical axis or on a Panda arm."""

from collections.abc import Sequence
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import pybullet_data

from egad.grasps import Gripper

PALM, LEFT, RIGHT, TIP = "palm", "left", "right", "tip"
PALM_MASS = 0.6
FINGER_MASS = 0.1
STROKE = 2.0  # metres, of the vertical axis, both ways
FLANGE = "panda_link8"
FIRST_OF_FRANKAS_HAND = "panda_hand_joint"
# The flange is turned by this against the hand of Franka, whose fingers close along y.
FLANGE_TURN = 0.785398163397
UPSIDE_DOWN = "3.141592653589793 0 0"
QUARTER = 1.57079632679


def on_axis(gripper: Gripper) -> str:
    """The hand on a vertical axis: at 0 the fingertips stand on the ground."""
    robot = Element("robot", name="hand")
    _link(robot, "stand")
    top = (0.0, 0.0, gripper.palm[2] + gripper.finger_length)
    limits = (-STROKE, STROKE)
    _joint(robot, "axis", "prismatic", "stand", PALM, top, "0 0 -1", limits, UPSIDE_DOWN)
    _hand(robot, gripper)
    return ElementTree.tostring(robot, encoding="unicode")


def on_panda(gripper: Gripper) -> str:
    """The arm of `pybullet_data` with this hand at its flange in the place of Franka's."""
    folder = Path(pybullet_data.getDataPath()) / "franka_panda"
    robot = ElementTree.parse(folder / "panda.urdf").getroot()  # noqa: S314 (of a package)
    names = [part.get("name") for part in robot]
    for part in robot[names.index(FIRST_OF_FRANKAS_HAND) :]:
        robot.remove(part)
    for mesh in robot.iter("mesh"):
        mesh.set("filename", mesh.attrib["filename"].replace("package:/", str(folder)))
    turn = f"0 0 {QUARTER - FLANGE_TURN!r}"
    _joint(robot, "flange", "fixed", FLANGE, PALM, turn=turn)
    _hand(robot, gripper)
    return ElementTree.tostring(robot, encoding="unicode")


def _hand(robot: Element, gripper: Gripper) -> None:
    """Palm and fingers as boxes: x closes, z is the approach, the palm begins at its origin."""
    length, palm = gripper.finger_length, gripper.palm
    finger = (gripper.finger_thickness, gripper.finger_width, length)
    _box(robot, PALM, palm, (0.0, 0.0, palm[2] / 2), PALM_MASS)
    for name, side in ((LEFT, 1), (RIGHT, -1)):
        _box(robot, name, finger, (side * finger[0] / 2, 0.0, length / 2), FINGER_MASS)
        limits = (0.0, gripper.opening / 2)
        _joint(robot, name, "prismatic", PALM, name, (0, 0, palm[2]), f"{side} 0 0", limits)
    _link(robot, TIP)
    _joint(robot, TIP, "fixed", PALM, TIP, (0, 0, palm[2] + length))


def _box(
    robot: Element,
    name: str,
    size: tuple[float, float, float],
    middle: tuple[float, float, float],
    mass: float,
) -> None:
    squares = [side**2 for side in size]
    moments = [mass / 12 * (sum(squares) - square) for square in squares]
    link = _link(robot, name, mass, moments, middle)
    for kind in ("visual", "collision"):
        part = SubElement(link, kind)
        SubElement(part, "origin", xyz=_text(middle), rpy="0 0 0")
        SubElement(SubElement(part, "geometry"), "box", size=_text(size))


def _link(
    robot: Element,
    name: str,
    mass: float = 0.0,
    moments: Sequence[float] = (0.0, 0.0, 0.0),
    middle: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> Element:
    link = SubElement(robot, "link", name=name)
    inertial = SubElement(link, "inertial")
    SubElement(inertial, "origin", xyz=_text(middle), rpy="0 0 0")
    SubElement(inertial, "mass", value=repr(mass))
    values = dict(zip(("ixx", "iyy", "izz"), map(repr, moments), strict=True))
    SubElement(inertial, "inertia", {**values, "ixy": "0", "ixz": "0", "iyz": "0"})
    return link


def _joint(
    robot: Element,
    name: str,
    kind: str,
    parent: str,
    child: str,
    origin: tuple[float, float, float] = (0, 0, 0),
    axis: str = "",
    limits: tuple[float, float] | None = None,
    turn: str = "0 0 0",
) -> None:
    joint = SubElement(robot, "joint", name=f"{name}_joint", type=kind)
    SubElement(joint, "origin", xyz=_text(origin), rpy=turn)
    SubElement(joint, "parent", link=parent)
    SubElement(joint, "child", link=child)
    if axis:
        SubElement(joint, "axis", xyz=axis)
    if limits:
        low, high = map(repr, limits)
        SubElement(joint, "limit", lower=low, upper=high, effort="1000", velocity="10")


def _text(values: tuple[float, float, float]) -> str:
    return " ".join(repr(float(value)) for value in values)

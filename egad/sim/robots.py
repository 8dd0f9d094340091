"""The robots of trials: a hand on a vertical axis, by itself, or at the flange of a Panda arm."""

import numpy as np

from egad.grippers import Gripper
from egad.sim.hands import HandParts, hand_parts
from egad.sim.robot import PALM, Box, Joint, Link, Robot, Vector

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


def on_axis(gripper: Gripper) -> Robot:
    """The hand on a vertical axis that turns: at 0 the fingertips are on the ground."""
    hand = hand_parts(gripper)
    top = (0.0, 0.0, hand.length)
    joints = [
        # Turned upside down, so that the hand points down
        Joint("height", "stand", "prismatic", top, (np.pi, 0, 0), (0, 0, -1), (-STROKE, STROKE)),
        Joint(PALM, "height", "revolute", axis=(0, 0, -1), limits=(-TURN, TURN)),
    ]
    strength = dict(zip(("height", PALM), AXIS_STRENGTH, strict=True))
    return _robot(gripper, hand, [Link("stand"), Link("height")], joints, strength)


def free_hand(gripper: Gripper) -> Robot:
    """The hand by itself, moved along its own axes: at 0 the fingertips are at the origin."""
    hand = hand_parts(gripper)
    root = (0.0, 0.0, -hand.length)
    names = ("along_x", "along_y", PALM)
    axes: tuple[Vector, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    joints = [
        Joint(name, parent, "prismatic", origin, axis=axis, limits=(-STROKE, STROKE))
        for name, parent, origin, axis in zip(
            names, ("stand", *names), (root, (0.0,) * 3, (0.0,) * 3), axes, strict=False
        )
    ]
    links = [Link("stand"), Link("along_x"), Link("along_y")]
    return _robot(gripper, hand, links, joints, dict.fromkeys(names, FREE_STRENGTH))


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
    hand = hand_parts(gripper)
    return _robot(gripper, hand, links, [*joints, flange], strength)


def _around(end: Vector) -> Box:
    """A box around the line from the origin of a link of the Panda to the end of the link."""
    x, y, z = (abs(value) + PANDA_THICKNESS for value in end)
    return Box((x, y, z), (end[0] / 2, end[1] / 2, end[2] / 2))


def _robot(
    gripper: Gripper,
    hand: HandParts,
    links: list[Link],
    joints: list[Joint],
    strength: dict[str, float],
) -> Robot:
    """A robot from the links and joints of an arm, and a hand."""
    links, joints = [*links, *hand.links], [*joints, *hand.joints]
    return Robot(gripper, tuple(links), tuple(joints), strength, *hand[3:])

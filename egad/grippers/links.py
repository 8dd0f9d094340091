"""The links of a described hand: their convex parts, and how they are connected."""

import mujoco
import numpy as np
from scipy.spatial import ConvexHull, QhullError

from egad.errors import UserError
from egad.grippers.description import shapes_of
from egad.grippers.fingers import Sides
from egad.grippers.model import FIRST_FINGER, PALM_BODY, SECOND_FINGER, HandLink, LinkJoint
from egad.grippers.tree import body_name, joint_name


def hand_link(model: mujoco.MjModel, body: int, bodies: list[int], sides: Sides) -> HandLink:
    """A link of a hand; `UserError` if it has several joints."""
    shapes = []
    for points in shapes_of(model, body):
        try:
            shapes.append(points[ConvexHull(points).vertices])
        except QhullError:  # it is flat, and touches nothing
            continue
    fingers = zip((FIRST_FINGER, SECOND_FINGER), sides.links, strict=True)
    side = next((side for side, links in fingers if body in links), PALM_BODY)
    carrier = int(model.body_parentid[body])
    moves = side != PALM_BODY and carrier in bodies
    place = np.eye(4)
    mujoco.mju_quat2Mat(turn := np.empty(9), model.body_quat[body])
    place[:3, :3], place[:3, 3] = turn.reshape(3, 3), model.body_pos[body]
    return HandLink(
        name=body_name(model, body),
        body=side,
        shapes=tuple(shapes),
        mass=float(model.body_mass[body]),
        carrier=bodies.index(carrier) if moves else -1,
        place=place,
        joint=_link_joint(model, body) if moves else None,
    )


def _link_joint(model: mujoco.MjModel, body: int) -> LinkJoint | None:
    first, count = int(model.body_jntadr[body]), int(model.body_jntnum[body])
    if count > 1:
        raise UserError(f"the link {body_name(model, body)} has more than one joint")
    return joint_at(model, first) if count else None


def joint_at(model: mujoco.MjModel, number: int) -> LinkJoint:
    """A joint by its number in the model."""
    slides = int(model.jnt_type[number]) == int(mujoco.mjtJoint.mjJNT_SLIDE)
    return LinkJoint(
        joint_name(model, number),
        "prismatic" if slides else "revolute",
        np.array(model.jnt_axis[number]),
        np.array(model.jnt_pos[number]),
        float(model.qpos0[model.jnt_qposadr[number]]),
    )

"""Which link of a description carries which, and which of them are the hand."""

from collections.abc import Sequence

import mujoco

from egad.errors import UserError

MOVING = {int(mujoco.mjtJoint.mjJNT_SLIDE), int(mujoco.mjtJoint.mjJNT_HINGE)}


def body_name(model: mujoco.MjModel, body: int) -> str:
    """Name of a link."""
    return str(model.body(body).name)


def joint_name(model: mujoco.MjModel, joint: int) -> str:
    """Name of a joint."""
    return str(model.joint(joint).name)


def link_number(model: mujoco.MjModel, name: str) -> int:
    """Number of a link, or `UserError`."""
    names = [body_name(model, body) for body in range(model.nbody)]
    if name not in names:
        raise UserError(f"it has no link {name!r}; it has {', '.join(names[1:])}")
    return names.index(name)


def moving_joints(model: mujoco.MjModel) -> list[int]:
    """Numbers of the joints that slide or turn."""
    return [joint for joint in range(model.njnt) if int(model.jnt_type[joint]) in MOVING]


def subtree(model: mujoco.MjModel, body: int) -> set[int]:
    """A link and all that it carries."""
    carried = {body}
    for other in range(body + 1, model.nbody):  # parents come first
        if model.body_parentid[other] in carried:
            carried.add(other)
    return carried


def ancestors(model: mujoco.MjModel, body: int) -> list[int]:
    """A link, what carries it, and so on to the root."""
    chain = [body]
    while chain[-1]:
        chain.append(int(model.body_parentid[chain[-1]]))
    return chain


def find_palm(model: mujoco.MjModel, fingers: Sequence[str] | None = None) -> tuple[int, list[int]]:
    """The link that carries the fingers, and the links on it that move.

    Joints between the root and the palm belong to an arm, and stay where they are.
    """
    if fingers is not None:
        first, second = (ancestors(model, link_number(model, name)) for name in fingers)
        common = [body for body in first if body in second]
        palm = max(common)
    else:
        palm = 0
        while len(chains := _moving_children(model, palm)) == 1:
            if not _moving_children(model, chains[0]):
                break
            palm = chains[0]
    chains = _moving_children(model, palm)
    if not chains:
        raise UserError("none of its joints moves")
    return palm, chains


def hand_bodies(model: mujoco.MjModel, palm: int) -> list[int]:
    """Numbers of the palm, of what it carries, and of what is fixed behind it."""
    behind, body = [], palm
    while body and not model.body_jntnum[body]:
        body = int(model.body_parentid[body])
        behind.append(body)
    return [palm, *sorted(subtree(model, palm) - {palm}), *(each for each in behind if each)]


def _moving_children(model: mujoco.MjModel, body: int) -> list[int]:
    moving = {int(model.jnt_bodyid[joint]) for joint in moving_joints(model)}
    children = [other for other in range(1, model.nbody) if model.body_parentid[other] == body]
    return [child for child in children if moving & subtree(model, child)]

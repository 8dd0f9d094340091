"""Grasp detectors: what they get, what they give, and which there are."""

from typing import Protocol

import numpy as np

from egad.errors import UserError
from egad.settings import Gripper
from egad.trials.antipodal import antipodal_depth
from egad.trials.camera import View
from egad.trials.grasp import Grasp


class Detector(Protocol):
    """Proposes grasps for what a depth camera sees."""

    def __call__(self, view: View, gripper: Gripper, rng: np.random.Generator, /) -> list[Grasp]:
        """Propose grasps, in any order; none if there is nothing to hold.

        Args:
            view: Depth image, intrinsics and pose of the camera; the table is at height 0.
            gripper: The hand that will try.
            rng: The only source of chance, so that an attempt can be repeated.
        """


DETECTORS: dict[str, Detector] = {"antipodal-depth": antipodal_depth}


def detector(name: str) -> Detector:
    """The detector of a name.

    Raises:
        UserError: There is none of that name.
    """
    if name not in DETECTORS:
        raise UserError(f"no grasp detector {name!r}; there are: {', '.join(sorted(DETECTORS))}")
    return DETECTORS[name]


def best(grasps: list[Grasp], gripper: Gripper) -> Grasp | None:
    """The grasp of the highest quality that the hand can do; the first of equals; or none."""
    possible = [grasp for grasp in grasps if grasp.fits(gripper)]
    return max(possible, key=lambda grasp: grasp.quality, default=None)

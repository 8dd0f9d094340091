"""random: a grasp anywhere on the object, as a baseline that does not look closely."""

import numpy as np

from egad.detectors.base import Grasp
from egad.detectors.camera import View
from egad.detectors.restoration import restore
from egad.grasps import TABLE_CLEARANCE
from egad.grippers import Gripper, check_jaws


def random_grasp(view: View, gripper: Gripper, rng: np.random.Generator) -> list[Grasp]:
    """One grasp, wide open, at a pixel that sees the object, at a random angle and quality (ours).

    The fingertips go as deep below the point as the fingers are long, but not onto the table.
    """
    check_jaws(gripper, "the detector random")
    points = restore(view).points().reshape(-1, 3)
    standing = points[points[:, 2] > TABLE_CLEARANCE]
    if len(standing) == 0:
        return []
    x, y, top = (float(part) for part in standing[rng.integers(len(standing))])
    tip = max(top - gripper.finger_length, TABLE_CLEARANCE)
    level = (top + tip) / 2
    angle = float(rng.uniform(-np.pi / 2, np.pi / 2))
    quality = float(rng.random())
    return [Grasp((x, y, level), angle, gripper.opening, level - tip, quality)]

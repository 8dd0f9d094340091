"""Collision of the hand with what the cameras see, on its way to a grasp."""

import numpy as np

from egad._util.arrays import Flags, Floats
from egad.grasps import TABLE_CLEARANCE
from egad.grippers import Gripper, check_jaws, finger_span

APPROACH_LENGTH = 0.05  # metres; length of the straight approach, which must be free, too


def in_collision(poses: Floats, widths: Floats, points: Floats, gripper: Gripper) -> Flags:
    """Whether the hand touches something at a grasp, or on the last 5 cm before it, (n,) (ours).

    Poses and widths are those of `GraspPoses`. It may touch points, (m, 3) metres, or the table at
    height 0; its palm and fingers are boxes. UserError if the gripper has a suction cup.
    """
    check_jaws(gripper, "a check for collisions with a point cloud")
    base, tip = finger_span(gripper)
    palm, side = np.array(gripper.palm) / 2, gripper.finger_width / 2
    back = base - gripper.palm[2]
    found = np.zeros(len(poses), dtype=np.bool_)
    for number, (pose, width) in enumerate(zip(poses, widths, strict=True)):
        x, y, z = ((points - pose[:3, 3]) @ pose[:3, :3]).T
        inner, outer = width / 2, width / 2 + gripper.finger_thickness
        fingers = (np.abs(x) >= inner) & (np.abs(x) <= outer) & (np.abs(y) <= side)
        fingers &= (z >= base - APPROACH_LENGTH) & (z <= tip)
        rest = (np.abs(x) <= palm[0]) & (np.abs(y) <= palm[1])
        rest &= (z >= back - APPROACH_LENGTH) & (z <= base)
        lowest = -max(pose[2, 2], 0.0) * APPROACH_LENGTH + _lowest(
            pose, [(outer, side, base, tip), (palm[0], palm[1], back, base)]
        )
        found[number] = lowest < TABLE_CLEARANCE or (fingers | rest).any()
    return found


def _lowest(pose: Floats, boxes: list[tuple[float, float, float, float]]) -> float:
    """Height of the lowest corner of boxes: half sides along x and y, from and to along z."""
    across = [abs(pose[2, 0]) * x + abs(pose[2, 1]) * y for x, y, _, _ in boxes]
    ends = [min(pose[2, 2] * low, pose[2, 2] * high) for _, _, low, high in boxes]
    return float(pose[2, 3] + min(end - wide for end, wide in zip(ends, across, strict=True)))

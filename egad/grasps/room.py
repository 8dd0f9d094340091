"""How much room a hand takes beside what it holds, and over the table (ours)."""

import numpy as np
from numpy.typing import NDArray

from egad.settings import Gripper

Floats = NDArray[np.float64]

TABLE_CLEARANCE = 0.003  # fingertips stay this far above whatever lies below them
SIDE_CLEARANCE = 0.008  # free space that is wanted on each side of what is held
LEAST_BITE = 0.003  # the fingertips reach at least this far below the contacts


def roomy(distance: Floats, gripper: Gripper) -> Floats:
    """How far to open for contacts this far apart: 8 mm more on each side, if the hand can."""
    width: Floats = np.minimum(distance + 2 * SIDE_CLEARANCE, gripper.opening)
    return width

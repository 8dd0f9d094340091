"""The opening that a grasp needs for the fingers of a maker's model, which may move on arcs."""

import numpy as np

from egad._util.arrays import Floats
from egad.geometry import RayCaster
from egad.grasps.approach import swallowed
from egad.grasps.collision import blocked_turns
from egad.grasps.sampler import ContactPairs
from egad.grippers import CLEARANCE, ModelBody

STRAIGHT = np.zeros(1)


def needed_openings_of_model(
    caster: RayCaster, grasps: ContactPairs, approaches: Floats, body: ModelBody
) -> Floats:
    """The smallest opening at which both fingers stand beside the object at each of n grasps.

    The hand stays where its pads will reach the contacts, and its fingers close along their path.
    Openings are tried as the model tabulates them, and the answer is one of these: it is too large
    by at most the distance of two.

    Args:
        caster: Ray caster of the object, closed, metres.
        grasps: The grasps.
        approaches: (n, 3) unit vectors along which the hand points, at right angles to the axes.
        body: The hand.

    Returns:
        (n,) metres between the pads, at least the widths of the grasps; infinite if the hand does
        not open that far.
    """
    frames = np.stack([grasps.axes, np.cross(approaches, grasps.axes), approaches], axis=1)
    needed = np.full(len(grasps), np.inf)
    openings = body.model.openings
    for level in np.flatnonzero(openings <= body.gripper.opening + CLEARANCE):
        opening = float(openings[level])
        rows = np.flatnonzero(np.isinf(needed) & (grasps.widths <= opening - CLEARANCE))
        if not len(rows):
            continue
        parts = body.at(int(level), fingers_only=True)
        behind = body.reach(grasps.widths[rows]) - body.reach(np.array([opening]))
        where = grasps.centers[rows], frames[rows], STRAIGHT
        inside = swallowed(caster, parts, *where, behind)
        blocked = blocked_turns(caster.triangles, parts, *where, known=inside, behind=behind)
        needed[rows[~blocked[:, 0]]] = opening
    return needed

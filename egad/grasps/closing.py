"""The opening that a grasp needs for the fingers of a maker's model, which may move on arcs."""

import numpy as np

from egad._util.arrays import Flags, Floats, Ints
from egad.geometry import RayCaster
from egad.grasps.antipodal import ContactPairs
from egad.grasps.approach import touching_turns
from egad.grippers import CLEARANCE, FINGERS, FIRST_FINGER, SECOND_FINGER, ModelBody


def needed_openings_of_model(
    caster: RayCaster, grasps: ContactPairs, approaches: Floats, body: ModelBody
) -> Floats:
    """The smallest opening at which both fingers stand beside the object at each of n grasps.

    The hand stays where its pads will reach the contacts, and its fingers close along their path.
    Only openings that the model tabulates are tried, so the result is too large by at most the step
    between two of them.

    Args:
        caster: Ray caster of the object, closed, metres.
        grasps: The grasps.
        approaches: (n, 3) unit vectors along which the hand points, at right angles to the axes.
        body: The hand.

    Returns:
        (n,) metres between the pads, at least the widths of the grasps; infinite if the hand does
        not open that far.
    """
    if body.model.lever is not None:
        return _needed_by_jaw(caster, grasps, approaches, body)
    frames = _frames(grasps, approaches)
    needed = np.full(len(grasps), np.inf)
    openings = body.model.openings
    for level in np.flatnonzero(openings <= body.gripper.opening + CLEARANCE):
        opening = float(openings[level])
        rows = np.flatnonzero(np.isinf(needed) & (grasps.widths <= opening - CLEARANCE))
        if not len(rows):
            continue
        parts = body.at(int(level), bodies=FINGERS)
        behind = body.reach(grasps.widths[rows]) - body.reach(np.array([opening]))
        where = grasps.centers[rows], frames[rows]
        blocked = touching_turns(caster, parts, *where, behind=behind)
        needed[rows[~blocked[:, 0]]] = opening
    return needed


def _needed_by_jaw(
    caster: RayCaster, grasps: ContactPairs, approaches: Floats, body: ModelBody
) -> Floats:
    """The same for a hand with one moving jaw, whose fixed jaw stands before the first contact.

    The moving jaw sweeps from wide open to the contact: what it meets on the way stops it there.
    """
    widths, openings = grasps.widths, body.model.openings
    levels = np.flatnonzero(openings <= body.gripper.opening + CLEARANCE)
    everything = np.arange(len(grasps))
    stands = ~_blocked(caster, grasps, approaches, body, everything, int(levels[-1]), FIRST_FINGER)
    needed = np.full(len(grasps), np.inf)
    left = stands.copy()
    for level in levels[::-1]:
        rows = np.flatnonzero(left & (widths <= openings[level] - CLEARANCE))
        if not len(rows):
            break
        blocked = _blocked(caster, grasps, approaches, body, rows, int(level), SECOND_FINGER)
        needed[rows[~blocked]] = openings[level]
        left[rows[blocked]] = False
    return needed


def _blocked(
    caster: RayCaster,
    grasps: ContactPairs,
    approaches: Floats,
    body: ModelBody,
    rows: Ints,
    level: int,
    side: int,
) -> Flags:
    """Whether one of the jaws touches the object at some of the grasps, (n,)."""
    chosen = grasps.take(rows)
    frames = _frames(chosen, approaches[rows])
    clearance = {"clearance": 0.0} if side == SECOND_FINGER else {}
    aside = body.aside(chosen.widths, body.model.openings[[level]], **clearance)
    origins = chosen.centers + aside[:, None] * chosen.axes
    parts = body.at(level, bodies=(side,))
    return np.asarray(touching_turns(caster, parts, origins, frames)[:, 0])


def _frames(grasps: ContactPairs, approaches: Floats) -> Floats:
    return np.stack([grasps.axes, np.cross(approaches, grasps.axes), approaches], axis=1)

"""A hand described by a URDF or MJCF file, and its sizes; MuJoCo is loaded only if there is one."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import manifold3d
import numpy as np

from egad._util.arrays import Floats
from egad._util.extras import needed_for
from egad.grippers.model import FINGERS, PALM_BODY, SECOND_FINGER, HandModel

FILE = "a gripper with a URDF or MJCF file"


def read_described(path: Path, values: Mapping[str, Any]) -> HandModel:
    """The hand that a file describes; settings that override what is found in the file count."""
    with needed_for(FILE):
        from egad.grippers.reading import choices_of, read_model  # noqa: PLC0415 (an extra)
    return read_model(path, choices_of(values))


MIN_SIDE = 1e-3  # metres, of a box


def sizes_of(model: HandModel) -> dict[str, Any]:
    """Opening, and sizes of boxes for fingers, measured at the pads, and palm, as in `Gripper`."""
    opening = float(model.openings[-1])
    closed = float(model.openings[0])
    fixed, finger = model.corners(closed, PALM_BODY), model.corners(closed, SECOND_FINGER)
    tip = float(max(points[:, 2].max() for points in finger))
    if model.lever is not None:  # of both jaws, over all openings
        every = (model.corners(float(each), *FINGERS) for each in model.openings)
        tip = float(max(points[:, 2].max() for jaws in every for points in jaws))
    low, high = _around_the_pad(finger, float(model.pad[0, 2]))
    behind = np.concatenate(fixed) if fixed else np.array([[0.0, 0.0, low[2] - MIN_SIDE]])
    face = min(float(behind[:, 2].max()), float(model.pad[0, 2]))
    palm = np.ptp(behind, axis=0)
    return {
        "opening": opening,
        "finger_length": _positive(tip + float(model.reach.min()) - face),
        "finger_width": _positive(high[1] - low[1]),
        "finger_thickness": _positive(high[0]),
        "fingertip": _positive(tip),
        "palm": tuple(_positive(size) for size in palm),
    }


def force_at_pads(model: HandModel, torque: float, force: float | None = None) -> float:
    """Newtons that a torque of the joint, N m, gives between the pads; `ValueError` if not so."""
    if model.lever is None or model.joint_kind != "revolute":
        raise ValueError("torque is for a hand with one jaw that turns; give its force instead")
    at_pads = torque / model.lever
    if force is not None and not math.isclose(force, at_pads, rel_tol=1e-6):
        raise ValueError(
            f"torque is {torque:g} N m, which gives {at_pads:.4g} N at the pads, {model.lever:.4g} "
            f"m from the hinge; force is {force:g}: leave out one of them"
        )
    return at_pads


def _around_the_pad(finger: list[Floats], lowest: float) -> tuple[Floats, Floats]:
    """Corners of the box around those parts of a finger that are beyond the pad's lower edge."""
    corners = []
    for points in finger:
        beyond = manifold3d.Manifold.hull_points(points).trim_by_plane((0.0, 0.0, 1.0), lowest)
        if not beyond.is_empty():
            corners.append(np.reshape(beyond.bounding_box(), (2, 3)))
    both = np.array(corners)
    return both[:, 0].min(axis=0), both[:, 1].max(axis=0)


def _positive(size: float) -> float:
    return max(round(float(size), 5), MIN_SIDE)

"""Randomly drawn errors of a real cell, and how an attempt deviates because of them."""

import math
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.spatial.transform import Rotation

from egad._util.arrays import Floats
from egad.bench.parameters import CellErrors
from egad.detectors import Grasp
from egad.grippers import Gripper
from egad.random import generator
from egad.sim import moved

SESSION = 20  # attempts at an object between two calibrations


@dataclass(frozen=True)
class Deviation:
    """How one attempt deviates from the plan."""

    # (4, 4) from where the hand should be to where it is, world frame
    motion: Floats = field(default_factory=lambda: np.eye(4))
    opening: float = 0.0  # how much too wide the hand opens, metres
    friction: float = 1.0  # friction of the pads / that of the gripper
    mass: float = 1.0  # mass of an object / that of its model
    stopping_force: float = 1.0  # force that stops the hand / that of the settings

    def apply(self, planned: Grasp, gripper: Gripper) -> Grasp:
        """A grasp as the hand executes it; a hand that comes from above stays vertical."""
        width = min(max(planned.width + self.opening, 0.0), gripper.opening)
        if planned.free_pose is not None:
            return replace(planned.moved(self.motion), width=width)
        x, y, z = moved(np.array([planned.center]), self.motion)[0].tolist()
        cosine, sine = math.cos(planned.angle), math.sin(planned.angle)
        along, across = cosine * self.motion[:2, 0] + sine * self.motion[:2, 1]
        turn = math.atan2(cosine * across - sine * along, cosine * along + sine * across)
        return replace(planned, center=(x, y, z), angle=planned.angle + turn, width=width)


EXACT: Deviation = Deviation()


def draw(errors: CellErrors, calibration: int, seed: int) -> Deviation:
    """Draw each error of an attempt independently; `calibration` seeds those that last."""
    calibrated, attempt = generator(calibration, "calibration"), generator(seed, "errors")
    shift, turn = calibrated.normal(size=(2, 3))
    *placed, opened = attempt.normal(size=4)
    shares = attempt.uniform(size=3)
    motion = np.eye(4)
    motion[:3, :3] = Rotation.from_rotvec(np.radians(errors.calibration_turn) * turn).as_matrix()
    motion[:3, 3] = errors.calibration * shift + errors.positioning * np.array(placed)
    ranges = (errors.friction, errors.mass, errors.stopping_force)
    friction, mass, force = (
        float(low + share * (high - low)) for (low, high), share in zip(ranges, shares, strict=True)
    )
    return Deviation(motion, float(errors.opening * opened), friction, mass, force)

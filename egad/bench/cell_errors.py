"""Errors of a real cell, and how an attempt deviates because of those that are drawn."""

import math
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Annotated, Self

import numpy as np
from pydantic import BeforeValidator, Field, model_validator
from scipy.spatial.transform import Rotation

from egad._util.arrays import Floats
from egad._util.parameters import Range, UserParameters, by_name
from egad.detectors import Grasp
from egad.grippers import Gripper
from egad.random import generator

SESSION = 20  # attempts at an object between two calibrations
Offset = Annotated[float, Field(ge=0, le=0.1)]


class CellErrors(UserParameters):
    """Errors of a real cell: none, typical (docs/trials.md), or a section of your own.

    Values are standard deviations of normal distributions; factors are uniform within ranges.
    """

    calibration: Offset = Field(
        0.0,
        description="error of the calibrated camera position along each axis, metres; sampled once "
        "for 20 attempts at an object, or for a round",
    )
    calibration_turn: float = Field(
        0.0,
        ge=0,
        le=10,
        description="error of the calibrated camera rotation about each axis through the middle of "
        "the table, where it was calibrated, degrees; sampled together with `calibration`",
    )
    positioning: Offset = Field(
        0.0, description="error of the hand's position along each axis, metres; sampled per attempt"
    )
    opening: Offset = Field(
        0.0, description="error of the hand's opening before it closes, metres; sampled per attempt"
    )
    friction: Range = Field(
        (1.0, 1.0),
        description="range of the factor on the friction of the pads; sampled per attempt",
    )
    mass: Range = Field(
        (1.0, 1.0), description="range of the factor on the mass of an object; sampled per attempt"
    )
    stopping_force: Range = Field(
        (1.0, 1.0),
        description="range of the factor on the force that stops the hand; sampled per attempt",
    )

    def __str__(self) -> str:
        """The name of these errors, or their values."""
        names = [name for name, errors in NAMED_ERRORS.items() if errors == self]
        return names[0] if names else super().__str__()

    @model_validator(mode="after")
    def _factors_can_be_drawn(self) -> Self:
        for name in ("friction", "mass", "stopping_force"):
            low, high = getattr(self, name)
            if not 0 < low <= high:
                raise ValueError(f"{name} must go from a positive low to high, got {low} to {high}")
        return self


NAMED_ERRORS: dict[str, CellErrors] = {
    "none": CellErrors(),
    "typical": CellErrors(
        calibration=0.0025,
        calibration_turn=0.5,
        positioning=0.001,
        opening=0.0005,
        friction=(0.75, 1.25),
        mass=(0.9, 1.1),
        stopping_force=(0.8, 1.2),
    ),
}


Errors = Annotated[CellErrors, BeforeValidator(partial(by_name, "errors", NAMED_ERRORS))]


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
        x, y, z = (self.motion[:3, :3] @ planned.center + self.motion[:3, 3]).tolist()
        cosine, sine = math.cos(planned.angle), math.sin(planned.angle)
        along, across, _ = self.motion[:3, :3] @ [cosine, sine, 0.0]
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

"""Simulated grasping trials, and the grasp detectors that are tried."""

from typing import Self

from pydantic import Field, model_validator

from egad.settings.base import Length, Section

SHIPPED = ("antipodal-depth", "ggcnn", "labels", "random")


class Trials(Section):
    """Simulated grasping trials."""

    attempts: int = Field(20, ge=1, description="attempts an object")
    image_size: int = Field(300, ge=16, le=2048, description="pixels a side of the depth image")
    camera_height: Length = Field(0.6, description="camera above the table, metres")
    field_of_view: float = Field(40.0, gt=1, lt=170, description="degrees, both ways")
    planning_time: float = Field(
        60.0, gt=0, description="seconds that a detector may take; then the attempt has failed"
    )
    lift_height: Length = Field(0.4, description="an object held this high counts, metres")
    hold_time: float = Field(1.0, ge=0, description="seconds that it must stay held up there")
    max_parts: int = Field(64, ge=1, description="most convex parts of an object")
    volume_error: float = Field(
        0.06, gt=0, lt=1, description="splitting into convex parts stops below this error"
    )


class Policy(Section):
    """A grasp detector under a name of its own."""

    detector: str = Field(
        description=f"one that is shipped ({', '.join(SHIPPED)}), or your own: FILE.py:CLASS or "
        "package.module:CLASS"
    )
    weights: str | None = Field(
        None, description="file that the detector is made with, such as the weights of a network"
    )

    @model_validator(mode="after")
    def _detector_can_be_found(self) -> Self:
        module, _, name = self.detector.rpartition(":")
        if self.detector not in SHIPPED and not (module and name.isidentifier()):
            raise ValueError(
                f"detector is {self.detector!r}; allowed: {', '.join(SHIPPED)}, "
                "FILE.py:CLASS or package.module:CLASS"
            )
        if self.weights and self.detector in SHIPPED and self.detector != "ggcnn":
            raise ValueError(f"the detector {self.detector} takes no `weights`")
        return self


POLICIES = {name: Policy(detector=name) for name in SHIPPED}

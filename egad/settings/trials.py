"""Simulated grasping trials."""

from pydantic import Field

from egad.settings.base import Length, Section


class Trials(Section):
    """Simulated grasping trials."""

    attempts: int = Field(20, ge=1, description="attempts an object")
    image_size: int = Field(300, ge=16, le=2048, description="pixels a side of the depth image")
    camera_height: Length = Field(0.6, description="camera above the table, metres")
    field_of_view: float = Field(40.0, gt=1, lt=170, description="degrees, both ways")
    lift_height: Length = Field(0.4, description="an object held this high counts, metres")
    hold_time: float = Field(1.0, ge=0, description="seconds that it must stay held up there")
    max_parts: int = Field(64, ge=1, description="most convex parts of an object")
    volume_error: float = Field(
        0.06, gt=0, lt=1, description="splitting into convex parts stops below this error"
    )

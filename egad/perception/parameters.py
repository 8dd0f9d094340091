"""Depth images to train detectors on."""

from typing import Self

from pydantic import Field, model_validator

from egad._util.parameters import (
    Angle,
    Fraction,
    FractionRange,
    Name,
    ParameterGroup,
    Parameters,
    Pixels,
    PositiveFraction,
    Range,
    check_ascending,
)
from egad.grasps.parameters import GraspLabel, Gripper


class Camera(Parameters):
    """A camera over the table, drawn anew for every image; ranges may be single values."""

    image: tuple[Pixels, Pixels] = Field(
        (300, 300), description="width and height of the depth image, pixels"
    )
    focal: Range = Field(description="focal length, pixels")
    distance: Range = Field(description="from the middle of the table, metres")
    tilt: tuple[Angle, Angle] = Field(description="off the vertical, degrees")
    roll: Range = Field((0.0, 0.0), description="about the optical axis, degrees")
    shift: float = Field(
        0.1,
        ge=0,
        le=1,
        description="how far the object may lie from the middle, along x and along y, metres",
    )
    centered: bool = Field(
        False, description="whether the image is cut out around the object's center of mass"
    )

    @model_validator(mode="after")
    def _ranges_can_be_drawn_from(self) -> Self:
        for name in ("focal", "distance", "tilt", "roll"):
            low, high = getattr(self, name)
            if low > high or (low <= 0 and name in ("focal", "distance")):
                raise ValueError(f"{name} must go from low to high, got {low} to {high}")
        return self


CAMERAS = {
    "d435": Camera(focal=(417.0, 417.0), distance=(0.55, 0.65), tilt=(0.0, 5.0)),
    "dexnet": Camera(
        focal=(520.0, 530.0),
        distance=(0.65, 0.75),
        tilt=(0.1, 5.0),
        roll=(-0.2, 0.2),
        centered=True,
    ),
}


class Render(Parameters):
    """Depth images of the objects as they come to rest, with their grasps."""

    images: int = Field(
        4000,
        ge=1,
        le=10_000_000,
        description="images of a dataset, however many objects it has; each split has its part of "
        "them, spread evenly over its objects",
    )
    camera: Name = Field("d435", description="camera of the table below")
    tilt: float = Field(
        15.0,
        gt=0,
        lt=90,
        description="grasps whose approach can be this near to the vertical are reachable, degrees",
    )
    complexity: FractionRange = Field(
        (0.0, 1.0),
        description="which objects, by their rank in complexity: [0, 0.33] is the simplest third",
    )
    subset: PositiveFraction = Field(1.0, description="how many of these, drawn by chance")
    validation: Fraction = Field(0.1, description="part of the objects, and of the images")
    test: Fraction = Field(0.1, description="the same")
    hold_out: bool = Field(
        True,
        description="whether all objects of the evaluation set are for testing, even if they are "
        "more than that",
    )

    @model_validator(mode="after")
    def _something_is_left(self) -> Self:
        if self.validation + self.test >= 1:
            raise ValueError("validation and test together must be less than 1")
        check_ascending(self, "complexity")
        return self


class ImageNoise(Parameters):
    """What a real depth camera does to these images; off by default."""

    disparity: float = Field(
        0.0,
        ge=0,
        le=10,
        description="standard deviation of the disparity, pixels: the error in depth grows with "
        "its square; 0.1 are 1.7 mm at 0.6 m",
    )
    shadows: bool = Field(
        False, description="whether what the second imager does not see, beside edges, has no depth"
    )
    missing: Fraction = Field(0.0, description="part of the pixels that is lost, in small spots")


class RenderParameters(ParameterGroup):
    """What rendered images depend on."""

    seed: int
    gripper: Gripper
    grasp_label: GraspLabel
    render: Render
    camera: Camera
    image_noise: ImageNoise

"""Settings of depth images for training detectors."""

from typing import Self

from pydantic import Field, model_validator

from egad._util.parameters import (
    Angle,
    Fraction,
    FractionRange,
    Length,
    Name,
    Parameters,
    Pixels,
    PositiveFraction,
    Range,
    check_ascending,
)
from egad.detectors import ImageNoise
from egad.geometry import Material
from egad.grasps import LabelParameters
from egad.sim import Lifting, SimulatedLabel, SimulatedLabelParameters


class Camera(Parameters):
    """A camera above the table, sampled anew for every image from ranges (low, high)."""

    image: tuple[Pixels, Pixels] = (300, 300)
    """width and height of the depth image, pixels"""
    focal: Range
    """range of the focal length, pixels"""
    distance: Range
    """range of the distance from the center of the table, metres"""
    tilt: tuple[Angle, Angle]
    """range of the angle to the vertical, degrees"""
    roll: Range = (0.0, 0.0)
    """range of the rotation about the optical axis, degrees"""
    shift: float = Field(0.1, ge=0, le=1)
    """largest offset of the object from the center, along x and along y, metres"""
    centered: bool = False
    """whether the image is cropped around the center of mass of the object"""

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
    """Depth images of objects at rest, with their grasps."""

    images: int = Field(4000, ge=1, le=10_000_000)
    """images per dataset, regardless of the number of objects; each split has its share,
    distributed evenly over its objects"""
    camera: Name = "d435"
    """camera, from the table `cameras`"""
    grasps: int = Field(100, ge=1)
    """maximum number of grasps sampled for each object in an image"""
    tilt: float = Field(15.0, gt=0, lt=90)
    """largest angle between the approach of a reachable grasp and the vertical, degrees"""
    widths: tuple[Length, Length] | None = None
    """range of grasp widths, metres: objects are shown in random sizes, such that the width of one
    of their grasps is uniform in this range; nothing: in the size that fits the gripper"""
    packed: Fraction = 0.0
    """fraction of the images that show several objects, upright, side by side"""
    pile: Fraction = 0.0
    """fraction of the images that show several objects in a pile"""
    objects: int = Field(5, ge=2, le=20)
    """number of objects in a pile, or to be packed"""
    quality: float = Field(0.001, ge=0)
    """robust quality above which a collision-free grasp is good; a simulated grasp is good if it
    held in simulation"""
    without_grasps: bool = False
    """whether images without a good grasp are kept; if not, another pose and size are sampled, at
    most 10 times"""
    simulate: bool = False
    """whether collision-free grasps are also closed, shaken and lifted in simulation (section
    simulated_label)"""
    complexity: FractionRange = (0.0, 1.0)
    """range of objects by rank in complexity: [0, 0.33] is the simplest third"""
    subset: PositiveFraction = 1.0
    """fraction of the objects within `complexity` to use, sampled at random"""
    validation: Fraction = 0.1
    """fraction of objects and images in the validation set"""
    test: Fraction = 0.1
    """fraction of objects and images in the test set"""
    hold_out: bool = True
    """whether all objects of the evaluation set are in the test set, even if they exceed its
    fraction; not if the set is the whole dataset"""

    @property
    def needs_convex_parts(self) -> bool:
        """Whether the images are made with a simulation."""
        return self.simulate or self.packed + self.pile > 0

    @model_validator(mode="after")
    def _something_is_left(self) -> Self:
        if self.validation + self.test >= 1:
            raise ValueError("validation and test together must be less than 1")
        if self.packed + self.pile > 1:
            raise ValueError("packed and pile together must be at most 1")
        check_ascending(self, "complexity")
        if self.widths:
            check_ascending(self, "widths")
        return self


class RenderParameters(LabelParameters):
    """The settings that rendered images depend on."""

    render: Render
    camera: Camera
    image_noise: ImageNoise


class RenderImages(RenderParameters):
    """Depth images of objects at rest; some need a simulation."""

    material: Material
    trials: Lifting
    simulated_label: SimulatedLabel

    @property
    def labels(self) -> SimulatedLabelParameters:
        """What simulated labels depend on."""
        names = SimulatedLabelParameters.model_fields
        return SimulatedLabelParameters(**{name: getattr(self, name) for name in names})

"""Settings of exports for other programs."""

from typing import NamedTuple, Self

from pydantic import Field, model_validator

from egad._util.parameters import Fraction, ParameterGroup, Parameters
from egad.geometry import Bundle, Material, Rescale
from egad.grasps import Quality, Robust
from egad.grippers import Gripper


class NamedGripper(NamedTuple):
    """A gripper, and what it is called."""

    name: str
    gripper: Gripper


class DexNet(Parameters):
    """Export as one HDF5 file for Dex-Net."""

    field_size: int = Field(40, ge=8, le=256)
    """nodes per side of a distance field; Dex-Net uses 100"""
    field_padding: int = Field(2, ge=1, le=64)
    """cells between the bounding box of the object and the edge of the field; Dex-Net uses 5 of
    100"""

    @model_validator(mode="after")
    def _the_object_fits_into_its_field(self) -> Self:
        if self.field_size < 4 * self.field_padding:
            raise ValueError(
                f"field_size must be at least 4 times field_padding, got {self.field_size} "
                f"and {self.field_padding}"
            )
        return self


class Acronym(Parameters):
    """Export as HDF5 files for acronym_tools."""

    min_robust_success_rate: Fraction = 0.5
    """minimum robust success rate of a grasp that counts as a success; the open hand must also be
    free of collisions at the grasp and on its straight approach, for the best of the approach
    angles tried"""


class GripperFormat(ParameterGroup):
    """A format that depends only on the gripper and the files that it reads."""

    gripper: Gripper


class AllObjects(ParameterGroup):
    """Objects whose mass and friction are not in a table."""

    gripper: Gripper
    material: Material
    bundle: Bundle


class AcronymFiles(ParameterGroup):
    """ACRONYM files."""

    gripper: Gripper
    quality: Quality
    acronym: Acronym


class DexNetDatabase(ParameterGroup):
    """A Dex-Net database: the grasps, and how they were rated."""

    gripper: Gripper
    quality: Quality
    robust: Robust


class RescaleMeshes(ParameterGroup):
    """Scaling to a gripper."""

    gripper: Gripper
    rescale: Rescale


class DexNetObjects(ParameterGroup):
    """Objects of a Dex-Net database: distance fields, stable poses, masses."""

    material: Material
    dexnet: DexNet

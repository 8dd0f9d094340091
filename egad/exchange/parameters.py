"""Files for other programs."""

from typing import Self

from pydantic import Field, model_validator

from egad._util.parameters import Fraction, Parameters


class DexNet(Parameters):
    """Dex-Net databases."""

    field_size: int = Field(
        40, ge=8, le=256, description="nodes a side of a distance field; Dex-Net's own have 100"
    )
    field_padding: int = Field(
        2,
        ge=1,
        le=64,
        description="cells of the field between the object's box and the edge; Dex-Net: 5 of 100",
    )
    pose_probability: Fraction = Field(
        0.01, description="stable poses less likely than this are left out"
    )

    @model_validator(mode="after")
    def _the_object_fits_into_its_field(self) -> Self:
        if self.field_size < 4 * self.field_padding:
            raise ValueError(
                f"field_size must be at least 4 field_padding, got {self.field_size} "
                f"and {self.field_padding}"
            )
        return self


class Acronym(Parameters):
    """ACRONYM files."""

    min_robust_success_rate: Fraction = Field(
        0.5,
        description="a grasp is a success if the open hand touches nothing at the grasp nor on its "
        "straight way in, at the best of the approach angles tried, and at least this part of its "
        "disturbed copies hold the object",
    )

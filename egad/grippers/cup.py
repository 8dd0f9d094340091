"""Settings of a suction cup."""

from typing import Any

from pydantic import Field, model_validator

from egad._util.display import facts_html
from egad._util.parameters import Length, UserParameters


class SuctionCup(UserParameters):
    """One suction cup on a straight stem: the model of Dex-Net 3.0.

    The cup is a pyramid of springs: a ring of `sides` vertices, and an apex on the approach axis.

    Source: Mahler et al., Dex-Net 3.0, ICRA 2018, arXiv 1709.06670: strain, vacuum force, friction
    and bending. GraspGen (NVlabs, `single_suction_cup_30mm.yaml`) has the same four values and
    gives radius, height and sides, which the paper does not. The stem is the collision cylinder of
    SuctionNet-1Billion. The tolerance is the residual that GraspGen's solver accepts.
    """

    radius: Length = Field(0.015, description="radius of the ring, metres; a 30 mm cup")
    height: Length = Field(
        0.03,
        description="distance from the ring to the apex, metres; twice the radius if not given",
    )
    sides: int = Field(15, ge=5, le=360, description="vertices of the ring")
    max_strain: float = Field(
        0.1, gt=0, lt=1, description="relative change of length that each spring allows"
    )
    vacuum_force: float = Field(
        250.0, gt=0, description="force that presses cup and object together, newtons"
    )
    friction: float = Field(0.5, gt=0, le=2, description="friction of the ring on the object")
    bending: float = Field(
        0.005,
        gt=0,
        description="kappa, newtons: the cup resists pi radius kappa / sqrt(2) of bending torque",
    )
    torque_tolerance: float = Field(
        0.0316,
        ge=0,
        description="bending torque beyond the limit given by `bending` that still counts as "
        "resisted, newton metres",
    )
    stem_radius: Length = Field(0.01, description="radius of the stem, metres")
    stem_length: Length = Field(
        0.09, description="length of the stem, starting at the apex, metres"
    )
    approach: Length = Field(
        0.1, description="length of the straight approach to the object, metres"
    )

    @model_validator(mode="before")
    @classmethod
    def _height_follows(cls, values: Any) -> Any:  # noqa: ANN401 (whatever was given)
        if not isinstance(values, dict) or values.get("height") is not None:
            return values
        radius = values.get("radius")
        if isinstance(radius, int | float) and radius > 0:
            return {**values, "height": 2 * radius}
        return values

    def _repr_html_(self) -> str:
        """All fields, for notebooks."""
        return facts_html("SuctionCup (metres, newtons)", dict(self))

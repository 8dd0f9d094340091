"""What is made of the objects: repair, scaling, the evaluation set, prints."""

from pydantic import Field

from egad._util.parameters import Parameters


class Material(Parameters):
    """What the objects are made of."""

    density: float = Field(400.0, gt=0, description="kg/m3; printed PLA at 20 % infill: 350-450")

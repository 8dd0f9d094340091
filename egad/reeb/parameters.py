"""The space that objects are spread over, and its measures."""

from typing import Literal

from pydantic import Field

from egad._util.parameters import Fraction, Parameters


class Similarity(Parameters):
    """Shape similarity: matching of multiresolutional Reeb graphs."""

    vertices: int = Field(4000, ge=4, description="split edges until a mesh has this many vertices")
    ranges: Literal[16, 32, 64, 128, 256] = Field(128, description="ranges of the finest graph")
    bases: Literal["even", "scan"] = Field(
        "even", description="`even`: farthest points; `scan`: the original's walk in vertex order"
    )
    base_count: int = Field(50, ge=1, description="number of bases (even)")
    base_coefficient: float = Field(
        0.005, gt=0, description="bases lie sqrt(this * area) apart (scan)"
    )
    weight: Fraction = Field(0.5, description="weight of area against length in a node's value")

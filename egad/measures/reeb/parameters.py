"""Settings of shape similarity."""

from typing import Literal

from pydantic import Field

from egad._util.parameters import Fraction, Parameters

Bases = Literal["even", "scan"]


class Similarity(Parameters):
    """Matching multiresolutional Reeb graphs."""

    vertices: int = Field(4000, ge=4)
    """edges are split until a mesh has this many vertices"""
    ranges: Literal[16, 32, 64, 128, 256] = 128
    """number of ranges of the finest graph"""
    bases: Bases = "even"
    """how base vertices are chosen: `even`: farthest points; `scan`: in vertex order, as in the
    original program"""
    base_count: int = Field(50, ge=1)
    """number of bases (bases: even)"""
    weight: Fraction = 0.5
    """weight of area relative to length in the value of a node"""

"""Settings of fingertips and of what they must fulfil."""

from typing import Annotated, Literal

from pydantic import Field

from egad._util.parameters import Length, Parameters

Tilt = Annotated[float, Field(ge=-30, le=30)]
Slope = Annotated[float, Field(ge=0, le=45)]
Depth = Annotated[float, Field(ge=0, le=0.05)]


class FingertipDesign(Parameters):
    """A plate for the inner face of each jaw, with a foot that fits the jaw; metres, degrees."""

    length: Length = Field(0.03, description="length of the plates beyond the jaws, metres")
    width: Length = Field(
        0.016, description="width of the plates, across the closing axis and the approach, metres"
    )
    thickness: Length = Field(0.004, description="thickness of the plates, metres")
    gap: Length = Field(
        0.03,
        description="distance at which the plates are parallel, metres; of no effect if jaws slide",
    )
    angle: Tilt = Field(
        0.0,
        description="angle between the plates there, degrees: positive if they are farther apart "
        "at their tips",
    )
    groove_angle: Slope = Field(
        0.0, description="slope of both flanks of a V groove, degrees; 0: none"
    )
    groove_depth: Depth = Field(0.0, description="depth of the groove, metres; 0: none")
    groove_direction: Literal["along", "across"] = Field(
        "along", description="direction of the groove: along the approach, or across it"
    )
    bevel: Depth = Field(
        0.0, description="bevel of the outer edge at the tip, 45 degrees, both sides, metres"
    )
    spacer: Depth = Field(
        0.0, description="distance between the plates and what protrudes most of the jaws, metres"
    )
    overlap: Length = Field(
        0.012, description="length of the jaws that the feet are glued or screwed on, metres"
    )


class TipLimits(Parameters):
    """What a design must fulfil on a printer and on a hand."""

    wall: Length = Field(0.0012, description="thinnest wall that is printed, metres")
    overhang: float = Field(
        4e-5, ge=0, description="surface that may hang over without support, square metres"
    )
    closed: Length = Field(0.0015, description="largest gap that may stay when closed, metres")
    smallest: Length = Field(
        0.02, description="smallest side of the smallest object, which the hand must span, metres"
    )
    mass: float = Field(0.05, gt=0, description="mass of both tips together at most, kilograms")
    density: float = Field(1240.0, gt=0, description="density of the plastic, kg/m3: PLA 1240")
    force: float = Field(3.0, gt=0, description="force between the pads at least, newtons")
    bend: Length = Field(
        0.001, description="how far a plate may bend under that force, at its tip, metres"
    )
    modulus: float = Field(
        2.3e9, gt=0, description="Young's modulus of the plastic, pascals: printed PLA 2.3e9"
    )

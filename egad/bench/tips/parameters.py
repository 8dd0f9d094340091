"""Settings of fingertips and of what they must fulfil."""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from egad._util.parameters import Fraction, Length, Parameters, Range, Seed, from_arguments
from egad.bench.hands import HandTrials

Tilt = Annotated[float, Field(ge=-30, le=30)]
Slope = Annotated[float, Field(ge=0, le=45)]
Depth = Annotated[float, Field(ge=0, le=0.05)]


class FingertipDesign(Parameters):
    """A plate for the inner face of each jaw, with a foot that fits the jaw; metres, degrees."""

    length: Length = Field(0.03, description="length of the plates beyond the jaws, metres")
    width: Length = Field(0.016, description="width of the plates and their feet, metres")
    thickness: Length = Field(0.004, description="thickness of the plates, metres")
    gap: Length = Field(
        0.03, description="how far apart the plates of a jaw that turns are parallel, metres"
    )
    angle: Tilt = Field(
        0.0, description="angle between the plates there, degrees; positive: farther at the tips"
    )
    groove_angle: Slope = Field(0.0, description="slope of the flanks of a V groove, degrees")
    groove_depth: Depth = Field(0.0, description="depth of the groove, metres; 0: none")
    groove_direction: Literal["along", "across"] = Field(
        "along", description="direction of the groove: along the approach, or across it"
    )
    bevel: Depth = Field(0.0, description="bevel of the outer edge at the tip, 45 degrees, metres")
    spacer: Depth = Field(0.0, description="distance from the jaws to the plates, metres")
    overlap: Length = Field(0.012, description="length of the feet along the jaws, metres")
    grip: Fraction = Field(0.5, description="where plates that turn hold: 0: at jaws, 1: at tips")
    mount: Literal["glue", "screw", "join"] = Field(
        "glue", description="how feet are held: glued, by two M3 screws, or printed with the jaw"
    )


class TipLimits(Parameters):
    """What a design must fulfil on a printer and on a hand."""

    wall: Length = Field(0.0012, description="thinnest wall that is printed, metres")
    smallest: Length = Field(0.02, description="smallest side of the smallest object, metres")
    mass: float = Field(
        0.05, gt=0, description="mass of both tips at most, kilograms, as solid PLA"
    )
    force: float = Field(3.0, gt=0, description="force between the pads at least, newtons")
    bend: Length = Field(0.001, description="how far the force may bend a plate at its tip, metres")


class TipSearch(Parameters):
    """A search for fingertips: what may vary, what they must fulfil, and how they are tried."""

    tips: dict[str, Range | float | tuple[str, ...] | str] = Field(
        description="for each dimension of the tips a range, [LOW, HIGH], or a value that fixes it"
    )
    limits: TipLimits = Field(TipLimits(), description="what tips must fulfil")
    evaluations: int = Field(48, ge=1, description="number of designs to simulate")
    generation: int = Field(8, ge=1, description="designs of a generation")
    objects: int = Field(16, ge=2, description="number of objects that designs are tried at")
    held_out: float = Field(
        0.5, gt=0, lt=1, description="fraction of the objects on which the tips are judged"
    )
    trials: HandTrials = Field(
        HandTrials(drops=1, search_drops=2, tries=2), description="attempts during the search"
    )
    judged: HandTrials = Field(HandTrials(), description="attempts by which tips are judged")
    seed: Seed = Field(0, description="seed of everything random")

    @model_validator(mode="after")
    def _ranges_are_possible(self) -> Self:
        """Each range is of a dimension, ascending, and both of its ends are allowed."""
        fields = FingertipDesign.model_fields
        for name, choice in self.tips.items():
            if name not in fields:
                raise ValueError(f"tips has no dimension {name}; allowed: {', '.join(fields)}")
            ends = choice if isinstance(choice, tuple) else (choice,)
            if isinstance(ends[0], float) and list(ends) != sorted(set(map(float, ends))):
                raise ValueError(f"tips.{name} is {list(ends)}; allowed: [LOW, HIGH]")
            for end in ends:
                from_arguments(FingertipDesign, **{name: end})
        return self

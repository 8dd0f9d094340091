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

    length: Length = 0.03
    """length of the plates beyond the jaws, metres"""
    width: Length = 0.016
    """width of the plates and their feet, metres"""
    thickness: Length = 0.004
    """thickness of the plates, metres"""
    gap: Length = 0.03
    """how far apart the plates of a jaw that turns are parallel, metres"""
    angle: Tilt = 0.0
    """angle between the plates there, degrees; positive: farther at the tips"""
    groove_angle: Slope = 0.0
    """slope of the flanks of a V groove, degrees"""
    groove_depth: Depth = 0.0
    """depth of the groove, metres; 0: none"""
    groove_direction: Literal["along", "across"] = "along"
    """direction of the groove: along the approach, or across it"""
    bevel: Depth = 0.0
    """bevel of the outer edge at the tip, 45 degrees, metres"""
    spacer: Depth = 0.0
    """distance from the jaws to the plates, metres"""
    overlap: Length = 0.012
    """length of the feet along the jaws, metres"""
    grip: Fraction = 0.5
    """where plates that turn hold: 0: at jaws, 1: at tips"""
    mount: Literal["glue", "screw", "join"] = "glue"
    """how feet are held: glued, by two M3 screws, or printed with the jaw"""


class TipLimits(Parameters):
    """What a design must fulfil on a printer and on a hand."""

    wall: Length = 0.0012
    """thinnest wall that is printed, metres"""
    smallest: Length = 0.02
    """smallest side of the smallest object, metres"""
    mass: float = Field(0.05, gt=0)
    """mass of both tips at most, kilograms, as solid PLA"""
    force: float = Field(3.0, gt=0)
    """force between the pads at least, newtons"""
    bend: Length = 0.001
    """how far the force may bend a plate at its tip, metres"""


class TipSearch(Parameters):
    """A search for fingertips: what may vary, what they must fulfil, and how they are tried."""

    tips: dict[str, Range | float | tuple[str, ...] | str]
    """for each dimension of the tips a range, [LOW, HIGH], or a value that fixes it"""
    limits: TipLimits = TipLimits()
    """what tips must fulfil"""
    evaluations: int = Field(48, ge=1)
    """number of designs to simulate"""
    generation: int = Field(8, ge=1)
    """designs of a generation"""
    objects: int = Field(16, ge=2)
    """number of objects that designs are tried at"""
    held_out: float = Field(0.5, gt=0, lt=1)
    """fraction of the objects on which the tips are judged"""
    trials: HandTrials = HandTrials(drops=1, search_drops=2, tries=2)
    """attempts during the search"""
    judged: HandTrials = HandTrials()
    """attempts by which tips are judged"""
    seed: Seed = 0
    """seed of everything random"""

    @model_validator(mode="after")
    def _ranges_are_possible(self) -> Self:
        """Each range is of a dimension, ascending, and both of its ends are allowed."""
        fields = FingertipDesign.model_fields
        for name, choice in self.tips.items():
            if name not in fields:
                raise ValueError(f"tips has no dimension {name}; allowed: {', '.join(fields)}")
            ends = choice if isinstance(choice, tuple) else (choice,)
            if name == "mount" and len(ends) > 1:
                raise ValueError("tips.mount is a list; allowed: one, as all are simulated alike")
            if isinstance(ends[0], float) and list(ends) != sorted(set(map(float, ends))):
                raise ValueError(f"tips.{name} is {list(ends)}; allowed: [LOW, HIGH]")
            for end in ends:
                from_arguments(FingertipDesign, **{name: end})
        return self
